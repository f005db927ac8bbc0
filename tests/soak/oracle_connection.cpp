// SPDX-License-Identifier: Apache-2.0
// What the oracle asks of connections to Modbus TCP servers that are closed or swallow everything.
#include <algorithm>

#include "soak/oracle.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr Duration kSilence = 30s;
constexpr Duration kLatest = 2s;  // that the process may be

void rest(Book& book) {
  book.forget_boots();
  book.reopening = {};
  book.open = false;
  book.starting = book.rests = true;
  book.flying.clear();
  book.unheard.clear();
  book.in_vain.clear();
  book.early_stops.insert(book.early_stops.end(), book.stops.begin(), book.stops.end());
  book.stops.clear();
}

}  // namespace

void Oracle::tcp_closed(std::size_t bus) {
  Book& book = books_[bus];
  note_cut(book);
  for (const std::uint64_t number : book.flying) {
    const Flight* cut = flight(number);
    if (cut == nullptr || schedule_.now() >= cut->deadline) {
      continue;
    }
    for (const std::uint64_t id : cut->asked) {
      if (const auto entry = open_.find(id); entry != open_.end()) {
        entry->second->cut = schedule_.now();
      }
    }
  }
  rest(book);
}

bool Oracle::may_be_wanted(std::size_t bus) {
  return books_[bus].rests && std::ranges::any_of(open_, [&](const auto& entry) {
           const Asked& asked = *entry.second;
           return asked.is_accepted && !asked.maybe_on_wire &&
                  std::ranges::find(asked.pieces, bus, &Piece::bus) != asked.pieces.end() &&
                  client_rates_.may_have_its_turn(asked, schedule_.now());
         });
}

bool Oracle::was_idle(std::size_t bus) const {
  const Book& book = books_[bus];
  return book.is_unused && schedule_.now() >= book.opened + bus_settings(bus).reopen_max;
}

void Oracle::line_replaced(std::size_t bus) {
  Book& book = books_[bus];
  if (!is_tcp(bus)) {
    const auto waits = [&](const Asked* stop) {
      return stop->accepted < schedule_.now() && is_surely_open(*stop);
    };
    if (std::ranges::any_of(book.stops, waits)) {
      violation("hung_line", bus_settings(bus).name + ": opened again before a stop");
    }
    const Reopening before = book.reopening;
    rest(book);
    book.reopening = before;
    book.is_restarted = true;
    return;
  }
  ++book.count.losses;
  note_cut(book);
  rest(book);
}

// Who asks is not kept waiting, neither while a connection rests nor by one that swallows
// everything. Of a gateway that stops only stops want it.
void Oracle::check_rest(std::size_t bus) {
  Book& book = books_[bus];
  const bool is_wanted = !book.early_stops.empty() || (!stopping_ && book.waiting > 0);
  if (book.rests && !book.opening && is_wanted && !finished_) {
    violation("tcp_not_opened", bus_settings(bus).name);
  }
  if (stopping_) {
    return;
  }
  const unsigned most = bus_settings(bus).replace_after;
  if (most == 0 || book.in_vain.size() < most || !book.open) {
    return;
  }
  const Flight* first = flight(book.in_vain.front());
  const Flight* last = flight(book.in_vain[most - 1]);
  if (first != nullptr && last != nullptr &&
      schedule_.now() > std::max(first->begin + kSilence, last->due) + kLatest) {
    violation("tcp_not_replaced", bus_settings(bus).name);
    book.in_vain.clear();
  }
}

// A read that nothing but the close has cut is asked once more.
void Oracle::judge_cut(const Asked& asked) {
  const auto& book = books_[asked.pieces.front().bus];
  if (!stopping_ && asked.is_read() && asked.cut && asked.flights == 1 &&
      book.last_down < *asked.cut &&
      schedule_.now() < asked.deadline - (asked.written - asked.earliest) &&
      !may_be_offline(asked) && !asked.pieces.front().taken_back) {
    violation("tcp_cut_read_failed", name(asked));
  }
}

}  // namespace mbgate::soak

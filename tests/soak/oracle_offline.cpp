// SPDX-License-Identifier: Apache-2.0
// Which devices are certainly offline: enough transmissions in a row on serial lines on which not a
// single byte was heard in answer. And what answers that were surely late show.
#include <algorithm>
#include <utility>

#include "soak/heard_answers.hpp"
#include "soak/oracle.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

// The length of its answer is known: it needs no silence behind it.
bool has_table(const PduBytes& pdu) {
  const auto fields = spec::fields_of(pdu);
  return fields && (fields->reads || fields->writes);
}

}  // namespace

bool Oracle::is_surely_offline(const Lane& lane) const {
  if (!lane.device) {
    return false;
  }
  const unsigned after = devices_[*lane.device].settings().timing.offline_after;
  return after > 0 && lane.silent >= after;
}

// Something else is transmitted now: the wait for the answer to what was last has ended.
void Oracle::note_silent(std::size_t bus) {
  Book& book = books_[bus];
  const Flight* last = flight(book.last_flight);
  if (last != nullptr && book.came > 0) {
    note_excused(*last);
  }
  if (is_tcp(bus) || last == nullptr || !last->expects_answer || last->is_broadcast ||
      last->begin < book.opened || !book.lanes[last->address].device) {
    return;
  }
  Lane& lane = book.lanes[last->address];
  // A stop may have ended the wait for it before it came.
  if (is_damaged_answer(plan_, book, *last) && book.use.first_read < deadline_of(*last)) {
    lane.unanswered -= lane.unanswered > 0 ? 1U : 0U;
    ++book.count.damaged;
    ++lane.count.damaged;
  }
  const bool is_silent = book.came == 0 && schedule_.now() >= last->due && reloaded_ < last->begin;
  if (!is_silent) {
    return;
  }
  ++book.count.silent;
  ++lane.count.silent;
  // An answer to the repetition is as old as the first try.
  lane.emptied_at = schedule_.now();
  lane.emptied_for = last->repeats_read ? lane.emptied_for : last->begin;
  lane.silent += last->is_stop ? 0U : 1U;
}

// A late answer that can be nothing else shows that its device is there.
void Oracle::note_alive(std::size_t bus, Lane& lane) const {
  if (is_past_offline(bus, lane)) {
    lane.last_offline = schedule_.now();
  }
  lane.stays_offline = false;
}

// Of a connection: what was asked before comes no more. A late one is known if not many others have
// had no answer since, and its device was asked for nothing else.
void Oracle::read_answers(std::size_t bus) {
  constexpr std::ptrdiff_t kRemembered = 64;
  Book& book = books_[bus];
  for (const std::uint64_t number : std::exchange(book.unread_answers, {})) {
    std::erase(book.misnamed, number);
    const Flight* answered = flight(number);
    if (answered == nullptr) {
      continue;
    }
    Lane& lane = book.lanes[answered->address];
    const auto is_later = [&](const auto& it) { return it->bus == bus && it->number > number; };
    const bool is_known = has_table(answered->pdu) && !lane.unheard.empty() &&
                          lane.unheard.back() == number &&
                          answered->begin >= std::max(book.opened, reloaded_) &&
                          schedule_.now() <= answered->deadline + answered->timing.quarantine_max &&
                          std::ranges::count_if(flights_, is_later) < kRemembered;
    if (!answered->is_answered && !is_known) {
      continue;
    }
    note_alive(bus, lane);
    std::erase_if(lane.unheard, [&](std::uint64_t asked) {
      const Flight* it = flight(asked);
      // What was heard is judged before a timeout that is over meanwhile.
      const bool still_waits =
          it != nullptr && !answered->is_answered && schedule_.now() <= it->due + lateness();
      return it == nullptr || (it->begin <= answered->begin && !still_waits);
    });
  }
}

}  // namespace mbgate::soak

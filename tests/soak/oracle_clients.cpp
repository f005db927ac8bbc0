// SPDX-License-Identifier: Apache-2.0
// The oracle's book of clients: what they asked, and when the gateway can first have taken it.
#include <algorithm>
#include <cstdio>

#include "gateway/limits.hpp"
#include "soak/oracle.hpp"
#include "soak/withdrawals.hpp"

namespace mbgate::soak {
namespace {

constexpr std::size_t kAnsweredKept = 256;
constexpr std::size_t kDoneKept = 400;
constexpr Duration kLongestBroadcast = std::chrono::seconds(6);  // on a slow line, in ASCII

// What its client address asked for later of the same device went behind it. A broadcast is a write
// to every device.
void let_go_behind(const Asked& first, const auto& open, Instant now) {
  const auto goes_behind = [&](const Piece& piece) {
    return std::ranges::any_of(first.pieces, [&](const Piece& own) {
      return own.bus == piece.bus &&
             (first.kind == Kind::broadcast || own.address == piece.address);
    });
  };
  for (const auto& [id, asked] : open) {
    if (asked->host == first.host && asked->sequence > first.sequence &&
        std::ranges::any_of(asked->pieces, goes_behind)) {
      asked->waited_until = now;
    }
  }
}

bool may_wait(const Asked& stop, const std::vector<Book>& books) {
  return stop.waits_from || std::ranges::any_of(stop.pieces, [&](const Piece& piece) {
           const auto& early = books[piece.bus].early_stops;
           return std::ranges::find(early, &stop) != early.end();
         });
}

}  // namespace

Oracle::Oracle(const SoakPlan& plan, const Devices& devices, const Schedule& schedule,
               Report& report)
    : plan_(plan),
      devices_(devices),
      schedule_(schedule),
      report_(report),
      writers_(plan),
      rates_(plan),
      client_rates_(plan),
      meanings_(plan),
      failsafe_(plan),
      books_(plan.settings.buses.size()) {
  map_lanes();
}

void Oracle::connect(ClientId client, std::size_t listener, unsigned host, bool has_tls) {
  client_rates_.came(client, listener, host);
  Session& session = sessions_[client];
  session.has_tls = has_tls;
  session.read_empty = schedule_.now();
  session.listener = listener;
  session.ordered = plan_.settings.listeners[listener].ordered;
}

std::uint64_t Oracle::ask(ClientId client, Asked asked) {
  asked.id = ++ids_;
  deny_by_rules(plan_, sessions_.at(client).listener, asked);
  if (asked.refused) {
    asked.pieces.clear();
  }
  writers_.refuse_unlisted(asked);
  asked.client = client;
  const Session& session = sessions_.at(client);
  asked.waits_in_pause = session.paused_since.has_value();
  asked.earliest = session.paused_since.value_or(schedule_.now());
  // The first pieces of what is read ahead have a mark each, and a request may come in several.
  // What its host may ask only later is read ahead, too.
  constexpr std::size_t kPieces = 4;
  constexpr std::size_t kFirstMarks = gateway::kArrivalMarks - gateway::kLastMarks;
  const auto is_held = [&](std::uint64_t id) {
    return client_rates_.may_hold(*open_.at(id), lateness(), schedule_.now());
  };
  const auto held = static_cast<std::size_t>(std::ranges::count_if(session.order, is_held));
  if (held + session.backlog.size() + 1 >= kFirstMarks / kPieces) {
    const auto first = std::ranges::find_if(session.order, is_held);
    const auto oldest = first != session.order.end() ? *first : session.backlog.front();
    asked.earliest = std::min(asked.earliest, open_.at(oldest)->earliest);
  }
  sessions_.at(client).by_transaction[asked.transaction] = asked.id;
  open_.emplace(ids_, std::make_unique<Asked>(std::move(asked)));
  ++report_.requests;
  return ids_;
}

void Oracle::begun(std::uint64_t id) {
  const auto entry = open_.find(id);
  if (entry == open_.end()) {
    return;
  }
  Asked& asked = *entry->second;
  asked.has_begun = true;
  client_rates_.begun(asked, schedule_.now());
  if (!asked.waits_in_pause) {
    asked.written = schedule_.now();
  }
}

void Oracle::half_closed(ClientId client) {
  Session& session = sessions_.at(client);
  session.half_closed = true;
  for (const std::uint64_t id : session.order) {
    Asked& asked = *open_.at(id);
    if (asked.changes() && !asked.is_stop()) {
      asked.dropped = true;
    }
  }
}

void Oracle::gone(ClientId client, const char* how) {
  const auto entry = sessions_.find(client);
  if (entry == sessions_.end()) {
    return;
  }
  std::vector<std::uint64_t> ids;
  for (const auto& [transaction, id] : entry->second.by_transaction) {
    ids.push_back(id);
  }
  std::ranges::sort(ids);
  for (const std::uint64_t id : ids) {
    Asked& asked = *open_.at(id);
    const auto& backlog = entry->second.backlog;
    if (asked.is_stop() && !asked.is_accepted && std::ranges::find(backlog, id) != backlog.end()) {
      accept(asked);  // received whole
    }
    if (asked.is_stop() && may_wait(asked, books_)) {
      Withdrawals(*this).note_taken(asked);
      asked.client_gone = true;  // it goes all the same
      continue;
    }
    perhaps_accepted_ += asked.ahead && !asked.surely_on_wire ? 1U : 0U;
    close(asked, how);
  }
  sessions_.erase(entry);
  failsafe_.gone(client);
}

// It frees its place at the end of its transmission; taken a little earlier here, which only errs
// to the permissive side.
void Oracle::end_without_reply(Asked& asked) {
  const auto entry = sessions_.find(asked.client);
  if (entry != sessions_.end()) {
    Session& session = entry->second;
    session.by_transaction.erase(asked.transaction);
    session.silent.push_back(asked.transaction);
    std::erase(session.order, asked.id);
    if (std::erase(session.backlog, asked.id) == 0) {
      --session.outstanding;  // a stop that was taken ahead has its place only later
    }
    session.ahead_until = schedule_.now() + kLongestBroadcast + 2 * lateness();
    close(asked, "after_answer");
    accept_backlog(session);
  }
}

void Oracle::closed(ClientId client) {
  const auto entry = sessions_.find(client);
  if (entry == sessions_.end()) {
    return;
  }
  for (const auto& [transaction, id] : entry->second.by_transaction) {
    const Asked& asked = *open_.at(id);
    if (asked.replies) {
      violation("closed_with_request", name(asked));
    }
  }
  gone(client);
}

void Oracle::close(Asked& asked, const std::string& how) {
  Withdrawals(*this).note_taken(asked);
  const bool present = asked.is_accepted && !asked.refused;
  for (Piece& piece : asked.pieces) {
    Book& book = books_[piece.bus];
    leave_queue(piece);
    if (present && !asked.is_stop() && is_first_on_its_bus(asked, piece)) {
      book.note_size(bus_settings(piece.bus).queue, schedule_.now());
      --book.present;
    }
    std::erase(book.lanes[piece.address].open, &asked);
    if (std::ranges::find(book.open_stops, &asked) != book.open_stops.end()) {
      cut_flying(book);
      std::erase(book.open_stops, &asked);
    }
    std::erase(book.stops, &asked);
    std::erase(book.early_stops, &asked);
    done_.push_back(
        {asked.id, piece.bus, piece.address, std::move(piece.pdu), how, schedule_.now()});
  }
  while (done_.size() > kDoneKept) {
    done_.pop_front();
  }
  const bool has_waited =
      present && !asked.maybe_on_wire && !asked.is_stop() && asked.accepted < schedule_.now();
  if (has_waited || (asked.kind == Kind::broadcast && asked.is_accepted)) {
    let_go_behind(asked, open_, schedule_.now());
  }
  client_rates_.closed(asked, schedule_.now());
  rates_.closed(asked, schedule_.now(), lateness());
  writers_.closed(asked, schedule_.now(), lateness());
  open_.erase(asked.id);
}

void Oracle::answered(ClientId client, Bytes adu) {
  const auto entry = sessions_.find(client);
  if (entry == sessions_.end()) {
    violation("answer_to_nobody", "an answer for a client that has gone");
    return;
  }
  Session& session = entry->second;
  const std::uint16_t transaction = spec::word_at(adu, 0);
  if (adu.size() < 9 || spec::word_at(adu, 2) != 0 || spec::word_at(adu, 4) != adu.size() - 6) {
    violation("malformed_answer", "an answer of " + std::to_string(adu.size()) + " bytes");
    return;
  }
  const auto place = session.by_transaction.find(transaction);
  if (place == session.by_transaction.end()) {
    const bool is_silent = std::erase(session.silent, transaction) > 0;
    const bool again = std::ranges::find(session.answered, transaction) != session.answered.end();
    session.outstanding += is_silent ? 1U : 0U;
    if (!is_silent || (adu[7] & 0x80U) == 0) {
      violation(is_silent ? "not_silent"
                : again   ? "second_answer"
                          : "unknown_answer",
                "transaction " + std::to_string(transaction));
    }
    return;
  }
  Asked& asked = *open_.at(place->second);
  // After a stop of the process nobody outside knows in which order it has read.
  if (!asked.is_accepted && asked.earliest == asked.written) {
    violation("pipeline", "answered before its place was free: " + name(asked));
  }
  if (std::erase(session.backlog, asked.id) > 0) {
    ++session.outstanding;
  }
  if (!asked.is_accepted) {
    ++sequence_;  // it was counted all the same
  }
  if (adu[6] != asked.unit) {
    violation("identifier", "unit " + std::to_string(adu[6]) + " for " + name(asked));
  }
  if (session.ordered && !session.order.empty()) {
    const Asked& oldest = *open_.at(session.order.front());
    if (oldest.id != asked.id && oldest.replies) {
      violation("answer_order", name(asked) + " before " + name(oldest));
    }
  }
  session.by_transaction.erase(place);
  session.answered.push_back(transaction);
  if (session.answered.size() > kAnsweredKept) {
    session.answered.pop_front();
  }
  std::erase(session.order, asked.id);
  judge(asked, adu.subspan(7));
}

void Oracle::violation(const std::string& kind, const std::string& text) const {
  const auto at =
      std::chrono::duration_cast<std::chrono::microseconds>(schedule_.now().time_since_epoch());
  if (traced_) {
    std::fprintf(stderr, "VIOLATION %s %s\n", kind.c_str(), text.c_str());
  }
  report_.violation(kind, "at " + std::to_string(at.count()) + " us: " + text);
}

}  // namespace mbgate::soak

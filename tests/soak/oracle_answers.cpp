// SPDX-License-Identifier: Apache-2.0
// The oracle's judgement of an answer: data that the device held meanwhile, or an exception that
// the rules allow for what happened on the wire.
#include <algorithm>

#include "soak/oracle.hpp"

namespace mbgate::soak {
namespace {

constexpr std::uint8_t kBusy = 0x06;
constexpr std::uint8_t kNoPath = 0x0A;
constexpr std::uint8_t kNoResponse = 0x0B;

std::string code_text(unsigned code) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  return {kDigits[code >> 4U & 15U], kDigits[code & 15U]};
}

bool is_bits(Table table) { return table == Table::coils || table == Table::discrete_inputs; }

}  // namespace

void Oracle::judge(Asked& asked, Bytes pdu) {
  const std::uint8_t function = asked.pdu.front();
  // What was read while a write waited that was then never sent is what the device holds.
  if (std::ranges::any_of(asked.pieces, [](const Piece& it) { return it.sent > 0; })) {
    note_write_event(asked);
  }
  if ((pdu[0] & 0x80U) != 0 && pdu.size() == 2 && pdu[0] == (function | 0x80U)) {
    ++report_.exceptions;
    ++report_.codes[pdu[1]];
    judge_exception(asked, pdu[1]);
    close(asked, "after_answer_" + code_text(pdu[1]));
    return;
  }
  ++report_.answers;
  if (pdu[0] != function) {
    violation("wrong_function", "function " + std::to_string(pdu[0]) + " for " + name(asked));
  } else if (asked.refused) {
    violation("not_refused", name(asked));
  } else if (asked.kind == Kind::own) {
    own_answer_.assign(pdu.begin(), pdu.end());
  } else {
    if (asked.check) {
      is_bits(asked.check->table) ? judge_bits(asked, pdu) : judge_data(asked, pdu);
    } else {
      judge_write(asked, pdu);
    }
    judge_place(asked);
    if (asked.kind != Kind::broadcast && !asked.silent && asked.maybe_on_wire) {
      device_answered(asked);
      if (asked.flights == asked.spoilt) {
        violation("after_wrong_echo", name(asked));
      }
    }
    well_ = asked.id;
  }
  close(asked, "after_answer");
}

void Oracle::judge_exception(const Asked& asked, std::uint8_t code) {
  if (asked.refused) {
    if (*asked.refused != code && !(asked.dropped && code == kBusy)) {
      violation("wrong_refusal", code_text(code) + " for " + name(asked));
    }
    return;
  }
  if (asked.kind == Kind::own) {
    violation("wrong_refusal", code_text(code) + " of the gateway's own unit");
    return;
  }
  switch (code) {
    case kBusy: judge_busy(asked); return;
    case kNoPath: judge_no_path(asked); return;
    case kNoResponse: judge_no_response(asked); return;
    default: break;
  }
  if (!asked.device_exceptions.test(code)) {
    violation("misdelivered_exception", code_text(code) + " for " + name(asked));
    return;
  }
  device_answered(asked);
}

void Oracle::device_answered(const Asked& asked) {
  Book& book = books_[asked.pieces.front().bus];
  Lane& lane = book.lanes[asked.pieces.front().address];
  if (asked.ordered) {
    return;  // it may have been held back, and much may have happened since
  }
  if (is_past_offline(asked, lane)) {
    lane.last_offline = schedule_.now();
  }
  lane.unanswered = static_cast<unsigned>(book.unheard.size());
}

bool Oracle::may_be_offline(const Asked& asked) const {
  if (!asked.door->device) {
    return false;
  }
  const Lane& lane = books_[asked.pieces.front().bus].lanes[asked.pieces.front().address];
  return lane.last_offline >= asked.accepted || is_past_offline(asked, lane);
}

bool Oracle::is_past_offline(const Asked& asked, const Lane& lane) const {
  const unsigned after = devices_[*asked.door->device].settings().timing.offline_after;
  return after > 0 && lane.unanswered >= after;
}

void Oracle::judge_busy(const Asked& asked) {
  if (asked.surely_on_wire) {
    violation("busy_after_wire", name(asked));
    return;
  }
  const bool expired = asked.deadline != Instant::max() &&
                       schedule_.now() >= asked.deadline - (asked.written - asked.earliest);
  // A stop also forbids writes that were read ahead when it came.
  const bool stopped =
      asked.changes() && std::ranges::any_of(asked.pieces, [&](const Piece& it) {
        const Book& book = books_[it.bus];
        return (asked.kind == Kind::broadcast ? book.last_stop
                                              : book.lanes[it.address].last_stop) >= asked.earliest;
      });
  const bool reason = expired || stopped || asked.dropped || asked.doomed ||
                      std::ranges::any_of(asked.pieces, [&](const Piece& piece) {
                        return books_[piece.bus].last_full >= asked.accepted;
                      });
  if (!reason) {
    violation(
        "busy_without_reason",
        name(asked) + ", deadline " +
            std::to_string((asked.deadline - schedule_.now()) / std::chrono::microseconds(1)) +
            " us from now, as old as " +
            std::to_string((schedule_.now() - asked.earliest) / std::chrono::microseconds(1)) +
            " us, accepted " +
            std::to_string((schedule_.now() - asked.accepted) / std::chrono::microseconds(1)) +
            " us ago");
  }
}

void Oracle::judge_no_path(const Asked& asked) {
  if (asked.surely_on_wire && asked.kind != Kind::broadcast) {
    violation("no_path_after_wire", name(asked));
    return;
  }
  const bool line_was_away = std::ranges::any_of(asked.pieces, [&](const Piece& piece) {
    return !books_[piece.bus].open || books_[piece.bus].last_down >= asked.accepted;
  });
  if (!line_was_away && (asked.is_read() || !may_be_offline(asked))) {
    violation("no_path_without_reason", name(asked));
  }
}

void Oracle::judge_no_response(const Asked& asked) {
  if (!asked.maybe_on_wire && !(asked.is_read() && may_be_offline(asked))) {
    violation("no_response_without_wire", name(asked));
  }
}

// Between these instants the device must have held what the answer shows.
Span Oracle::span_of(const Asked& asked) const {
  const Duration cache = devices_[*asked.door->device].settings().cache;
  Instant first = asked.accepted;
  if (cache > Duration{0}) {
    const Lane& lane = books_[asked.pieces.front().bus].lanes[asked.pieces.front().address];
    const Instant last_write =
        lane.last_write_event <= asked.accepted ? lane.last_write_event : Instant::min();
    first = std::max(asked.accepted - cache, last_write);
    for (const Asked* write : lane.open) {
      if (write->changes() && !write->ordered && !write->client_gone &&
          write->accepted < asked.accepted) {
        first = std::max(first, write->accepted);  // it waits: it was taken, and nothing kept since
      }
    }
  }
  return {first, schedule_.now()};
}

void Oracle::judge_data(const Asked& asked, Bytes pdu) {
  const ReadCheck& check = *asked.check;
  if (pdu.size() != 2U + 2U * check.count || pdu[1] != pdu.size() - 2) {
    violation("wrong_length", std::to_string(pdu.size()) + " bytes for " + name(asked));
    return;
  }
  const Span span = span_of(asked);
  const Registers& registers = devices_[*asked.door->device].registers();
  for (unsigned at = 0; at < check.count; ++at) {
    const unsigned shown = check.first + at;
    const std::uint16_t value = modbus::load_be16(pdu, 2 + 2 * std::size_t{at});
    if (is_in_pair(check.table, shown) && pair_of(shown) == shown && at + 1 < check.count) {
      const std::uint32_t next = modbus::load_be16(pdu, 4 + 2 * std::size_t{at});
      const std::uint32_t words =
          check.swapped ? (next << 16U) | value : (std::uint32_t{value} << 16U) | next;
      if (!registers.pair_held(shown, words, span)) {
        wrong_data(asked, "value at " + std::to_string(shown));
        return;
      }
      ++at;
      continue;
    }
    const unsigned address =
        check.swapped && is_in_pair(check.table, shown) ? partner_of(shown) : shown;
    if (!registers.held(check.table, address, value, span)) {
      const std::uint16_t held = registers.read(check.table, address, schedule_.now());
      wrong_data(asked, "register " + std::to_string(address) + " shows " + std::to_string(value) +
                            ", now it holds " + std::to_string(held));
      return;
    }
  }
}

void Oracle::wrong_data(const Asked& asked, const std::string& text) {
  if (plan_.beyond) {
    ++report_.apart["misdelivered_beyond_quarantine"];
    return;
  }
  const auto ago = [&](Instant at) {
    return std::to_string((schedule_.now() - at) / std::chrono::microseconds(1)) + " us ago";
  };
  violation("misdelivered", text + ": " + name(asked) + ", accepted " + ago(asked.accepted) +
                                ", nothing older than " + ago(span_of(asked).first));
}

void Oracle::judge_bits(const Asked& asked, Bytes pdu) {
  const ReadCheck& check = *asked.check;
  if (pdu.size() != 2U + (check.count + 7U) / 8U || pdu[1] != pdu.size() - 2) {
    violation("wrong_length", std::to_string(pdu.size()) + " bytes for " + name(asked));
    return;
  }
  const Registers& registers = devices_[*asked.door->device].registers();
  for (unsigned at = 0; at < check.count; ++at) {
    const auto bit = static_cast<std::uint16_t>(pdu[2 + at / 8] >> (at % 8) & 1U);
    if (!registers.held(check.table, check.first + at, bit, span_of(asked))) {
      wrong_data(asked, "bit " + std::to_string(check.first + at));
      return;
    }
  }
}

void Oracle::judge_write(const Asked& asked, Bytes pdu) {
  const std::size_t size = std::min<std::size_t>(asked.pdu.size(), 5);
  if (pdu.size() != size || !std::equal(pdu.begin(), pdu.end(), asked.pdu.begin())) {
    violation("wrong_echo", name(asked));
  }
  const bool sent = std::ranges::all_of(asked.pieces, [](const Piece& it) { return it.sent > 0; });
  const bool done = std::ranges::all_of(asked.pieces, [](const Piece& it) { return it.executed; });
  // The acknowledgement of a stop may be that of the same stop a moment ago, which was carried out;
  // nothing that moves comes between.
  const bool must_be_done = !asked.silent && asked.kind == Kind::write;
  if (!sent || (!done && must_be_done)) {
    if (plan_.beyond) {
      ++report_.apart["acknowledged_beyond_quarantine"];
      return;
    }
    violation("write_not_done", name(asked));
  }
}

// Nobody is shown what was read before an earlier write of the same connection.
void Oracle::judge_place(const Asked& asked) {
  if (!asked.is_read()) {
    return;
  }
  const Piece& piece = asked.pieces.front();
  for (const Asked* other : books_[piece.bus].lanes[piece.address].open) {
    if (other->kind == Kind::write && other->client == asked.client &&
        other->sequence < asked.sequence && !other->maybe_on_wire && !other->doomed &&
        !other->dropped && is_surely_open(*other)) {
      violation("before_own_write", name(asked) + " was answered before " + name(*other));
    }
  }
}

}  // namespace mbgate::soak

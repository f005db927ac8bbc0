// SPDX-License-Identifier: Apache-2.0
// The oracle's judgement of what an answer shows.
#include <algorithm>

#include "soak/identity.hpp"
#include "soak/oracle.hpp"
#include "soak/pdus.hpp"

namespace mbgate::soak {

void Oracle::judge_content(const Asked& asked, Bytes pdu) {
  if (asked.identity) {
    judge_identity(asked, pdu);
  } else if (!asked.check) {
    judge_echo(asked, pdu);
  } else if (asked.check->table == Table::coils || asked.check->table == Table::discrete_inputs) {
    judge_bits(asked, pdu);
  } else {
    judge_data(asked, pdu);
  }
}

// 05, 06, 15 and 16 repeat four bytes, 22 and those that name no table everything.
void Oracle::judge_echo(const Asked& asked, Bytes pdu) {
  const bool whole = asked.pdu.front() == 0x16 || asked.has_no_table;
  const std::size_t size = whole ? asked.pdu.size() : std::min<std::size_t>(asked.pdu.size(), 5);
  if (pdu.size() == size && std::equal(pdu.begin(), pdu.end(), asked.pdu.begin())) {
    return;
  }
  if (asked.has_no_table) {
    wrong_data(asked, hex(pdu));  // nobody but its client can know what it should be
  } else {
    violation("wrong_echo", name(asked));
  }
}

// Input registers of the device, as many as it likes.
void Oracle::judge_identity(const Asked& asked, Bytes pdu) {
  const Span span = span_of(asked);
  const Registers& registers = devices_[*asked.door->device].registers();
  const spec::Bytes request = asked.pieces.front().pdu;
  const auto no_word = [](unsigned, std::size_t) { return 0U; };
  unsigned count = shown_by(request, kMostIdentity);
  while (count > 1 && identity_answer(request, count, no_word).size() > pdu.size()) {
    --count;
  }
  bool held = true;
  const auto shown = [&](unsigned address, std::size_t at) {
    const auto value =
        static_cast<std::uint16_t>(request[0] == 0x07 ? pdu[at] : spec::word_at(pdu, at));
    held =
        held && (request[0] == 0x07 ? registers.low_held(Table::input_registers, address,
                                                         static_cast<std::uint8_t>(value), span)
                                    : registers.held(Table::input_registers, address, value, span));
    return unsigned{value};
  };
  if (identity_answer(request, count, no_word).size() != pdu.size() ||
      !std::ranges::equal(identity_answer(request, count, shown), pdu)) {
    violation("wrong_length", hex(pdu) + " for " + name(asked));
  } else if (!held) {
    wrong_data(asked, "identity " + hex(pdu));
  }
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
    const std::uint16_t value = spec::word_at(pdu, 2 + 2 * std::size_t{at});
    if (is_in_pair(check.table, shown) && pair_of(shown) == shown && at + 1 < check.count) {
      const std::uint32_t next = spec::word_at(pdu, 4 + 2 * std::size_t{at});
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
        check.swapped && is_in_value(check.table, shown) ? partner_of(shown) : shown;
    if (!registers.held(check.table, address, value, span)) {
      const std::uint16_t held = registers.read(check.table, address, schedule_.now());
      wrong_data(asked, "register " + std::to_string(address) + " shows " + std::to_string(value) +
                            ", now it holds " + std::to_string(held));
      return;
    }
  }
}

void Oracle::wrong_data(const Asked& asked, const std::string& text) {
  if (is_apart(asked, "misdelivered_")) {
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
  const Span span = span_of(asked);
  const Registers& registers = devices_[*asked.door->device].registers();
  for (unsigned at = 0; at < check.count; ++at) {
    const auto bit = static_cast<std::uint16_t>(pdu[2 + at / 8] >> (at % 8) & 1U);
    if (!registers.held(check.table, check.first + at, bit, span)) {
      wrong_data(asked, "bit " + std::to_string(check.first + at));
      return;
    }
  }
}

}  // namespace mbgate::soak

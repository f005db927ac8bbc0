// SPDX-License-Identifier: Apache-2.0
#include "world/drive.hpp"

namespace mbgate::world {
namespace {

constexpr std::uint8_t kIllegalAddress = 2;
constexpr std::uint8_t kIllegalValue = 3;

bool is_within(const std::optional<Range>& range) {
  if (!range) {
    return true;
  }
  const unsigned end = is_bits(range->table)                      ? kCoils
                       : range->table == Table::holding_registers ? kRegisters
                                                                  : kInputs;
  return range->first + range->count <= end;
}

Octets exception(std::uint8_t function, std::uint8_t code) {
  return {static_cast<std::uint8_t>(function | 0x80U), code};
}

}  // namespace

bool is_silent_write(Bytes pdu) {
  const auto cells = cells_of(pdu);
  return pdu[0] != 0x17 && pdu[0] != 0x16 && std::ranges::any_of(cells, [](const Cell& cell) {
           return cell.table == Table::holding_registers && cell.place == kSilentRegister &&
                  cell.word >> 12U == 7U;
         });
}

std::optional<Octets> Drive::carry_out(Ledger& ledger, Id sent, Octets pdu, Instant now) {
  const auto fields = fields_of(pdu);
  if (!fields) {
    return exception(pdu[0], kIllegalValue);
  }
  if (!is_within(fields->reads) || !is_within(fields->writes)) {
    return exception(pdu[0], kIllegalAddress);
  }
  const auto cells = cells_of(pdu);
  if (!cells.empty()) {
    const auto id = static_cast<Id>(ledger.done.size());
    ledger.done.push_back({sent, now});
    const Sent& frame = ledger.sent[sent];
    const std::size_t place = frame.is_broadcast ? all_of(frame.bus) : *frame.station;
    for (const Cell& cell : cells) {
      ledger.doers[key_of(place, cell)].push_back(id);
    }
  }
  if (fields->writes) {
    write(pdu[0], *fields, now);
    if (is_silent_write(pdu)) {
      return std::nullopt;
    }
  }
  if (fields->reads) {
    return read(pdu[0], *fields->reads, now);
  }
  if (is_read(pdu)) {
    return tell(pdu, now);
  }
  constexpr std::size_t kHead = 5;  // of 15 and 16 (6.11, 6.12)
  if (pdu[0] == 0x0F || pdu[0] == 0x10) {
    pdu.resize(kHead);
  }
  return pdu;
}

Octets Drive::read(std::uint8_t function, const Range& range, Instant now) const {
  const std::size_t size = data_size_of(range);
  Octets answer(2 + size);
  answer[0] = function;
  answer[1] = low(static_cast<unsigned>(size));
  for (unsigned at = 0; at < range.count; ++at) {
    const unsigned value = registers_.read(range.table, range.first + at, now);
    if (is_bits(range.table)) {
      answer[2 + at / 8] = low(answer[2 + at / 8] | value << at % 8);
    } else {
      answer[2 + 2 * std::size_t{at}] = high(value);
      answer[3 + 2 * std::size_t{at}] = low(value);
    }
  }
  return answer;
}

// Each ends in the first input registers, so that the judge can date it.
Octets Drive::tell(Bytes pdu, Instant now) const {
  const unsigned first = registers_.read(Table::input_registers, 0, now);
  const unsigned second = registers_.read(Table::input_registers, 1, now);
  switch (pdu[0]) {
    case 0x07: return {0x07, low(first)};
    case 0x0B: return {0x0B, high(first), low(first), high(second), low(second)};
    case 0x0C:
    case 0x11: return {pdu[0], 4, high(first), low(first), high(second), low(second)};
    case 0x18: return {0x18, 0, 6, 0, 2, high(first), low(first), high(second), low(second)};
    case 0x14: return {0x14, 6, 5, 6, high(first), low(first), high(second), low(second)};
    case 0x2B:
      return {0x2B,       kIdentification, 1,          1, 0, 0, 1, 0, 4, high(first),
              low(first), high(second),    low(second)};
    default: return exception(pdu[0], 1);
  }
}

void Drive::write(std::uint8_t function, const Fields& fields, Instant now) {
  const Range& range = *fields.writes;
  if (function == 0x16) {
    const unsigned before = registers_.read(range.table, range.first, now);
    const unsigned keep = fields.words[0];
    const unsigned after = (before & keep) | (fields.words[1] & ~keep);
    registers_.write(range.table, range.first, static_cast<std::uint16_t>(after), now);
    return;
  }
  for (unsigned at = 0; at < range.count; ++at) {
    registers_.write(range.table, range.first + at, fields.words[at], now);
  }
}

}  // namespace mbgate::world

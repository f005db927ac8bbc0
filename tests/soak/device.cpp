// SPDX-License-Identifier: Apache-2.0
#include "soak/device.hpp"

#include <array>

#include "soak/identity.hpp"

namespace mbgate::soak {

using modbus::Pdu;

namespace {

constexpr std::uint8_t kIllegalFunction = 1;
constexpr std::uint8_t kIllegalAddress = 2;
constexpr std::uint8_t kIllegalValue = 3;

bool is_bits(Table table) { return table == Table::coils || table == Table::discrete_inputs; }

bool is_within(const std::optional<spec::Range>& range) {
  return !range || range->first + range->count <= (is_bits(range->table) ? kCoils : kRegisters);
}

Pdu exception(spec::Bytes request, std::uint8_t code) {
  const std::array<std::uint8_t, 2> bytes{static_cast<std::uint8_t>(request[0] | 0x80U), code};
  return *Pdu::from(bytes);
}

// What a request of an unknown function says first, if it says more than that.
std::uint8_t command_of(spec::Bytes request) {
  constexpr std::size_t kShort = 4;
  if (!spec::is_opaque(request) || request.size() < kShort) {
    return kKnownCommand;
  }
  return request[request[0] == 0x2B ? 2 : 1];
}

// 05, 06 and 22 are repeated; of 15 and 16 address and quantity are (6.5, 6.6, 6.11, 6.12, 6.16).
Pdu acknowledgement(spec::Bytes request) {
  constexpr std::size_t kHead = 5;
  const bool is_run = request[0] == 0x0F || request[0] == 0x10;
  return *Pdu::from(is_run ? request.first(kHead) : request);
}

}  // namespace

bool is_silent(const spec::Fields& fields) {
  if (fields.reads || !fields.writes || fields.writes->table != Table::holding_registers ||
      fields.words.size() != fields.writes->count) {
    return false;
  }
  const spec::Range& range = *fields.writes;
  return range.first <= kSilentRegister && range.first + range.count > kSilentRegister &&
         fields.words[kSilentRegister - range.first] >> 12U == 7U;
}

bool is_listen_only(spec::Bytes request) {
  return request.size() > 2 && request[0] == 0x08 && request[1] == 0 &&
         (request[2] == 1 || request[2] == 4);
}

SoakDevice::Outcome SoakDevice::carry_out(const Pdu& pdu, Instant now) {
  const spec::Bytes request = pdu.bytes();
  const auto fields = spec::fields_of(request);
  if (!fields) {
    return {exception(request, kIllegalValue)};
  }
  if (!is_within(fields->reads) || !is_within(fields->writes)) {
    return {exception(request, kIllegalAddress)};
  }
  if (fields->writes) {
    write(request, *fields, now);
    if (is_silent(*fields)) {
      die_until(now + settings_.profile.unanswered.front().after);
      return {.answer = {}, .parting = acknowledgement(request)};
    }
  }
  if (is_listen_only(request) || command_of(request) == kUnheardCommand) {
    return {};
  }
  return {answer_to(request, *fields, now), is_slow(request)};
}

Pdu SoakDevice::answer_to(spec::Bytes request, const spec::Fields& fields, Instant now) const {
  if (fields.reads) {
    return read(request, *fields.reads, now);
  }
  if (asks_identity(request)) {
    return identify(request, now);
  }
  if (command_of(request) == kRefusedCommand) {
    return exception(request, kIllegalFunction);
  }
  return acknowledgement(request);
}

// Nobody knows before how much it is.
Pdu SoakDevice::identify(spec::Bytes request, Instant now) const {
  const auto value = [&](unsigned at, std::size_t /*place*/) {
    return registers_.read(Table::input_registers, at, now);
  };
  return *Pdu::from(
      identity_answer(request, shown_by(request, 1U + value(0, 0) % kMostIdentity), value));
}

Pdu SoakDevice::read(spec::Bytes request, const spec::Range& asked, Instant now) const {
  spec::Range range = asked;
  if (range.table == Table::input_registers && settings_.profile.input_as_holding) {
    range.table = Table::holding_registers;
  }
  const bool bits = is_bits(range.table);
  const std::size_t size = spec::data_size_of(range);
  std::vector<std::uint8_t> bytes(2 + size);
  bytes[0] = request[0];
  bytes[1] = static_cast<std::uint8_t>(size);
  for (unsigned at = 0; at < range.count; ++at) {
    const unsigned value = registers_.read(range.table, range.first + at, now);
    if (bits) {
      bytes[2 + at / 8] = static_cast<std::uint8_t>(bytes[2 + at / 8] | (value << (at % 8)));
    } else {
      bytes[2 + 2 * std::size_t{at}] = static_cast<std::uint8_t>(value >> 8U);
      bytes[3 + 2 * std::size_t{at}] = static_cast<std::uint8_t>(value & 0xFFU);
    }
  }
  return *Pdu::from(bytes);
}

void SoakDevice::write(spec::Bytes request, const spec::Fields& fields, Instant now) {
  if (request[0] == 0x16) {
    mask(fields, now);
  } else if (fields.writes->table == Table::holding_registers) {
    write_registers(fields, now);
  } else {
    for (unsigned at = 0; at < fields.writes->count; ++at) {
      registers_.write_coil(fields.writes->first + at, fields.words[at] != 0, now);
    }
  }
}

void SoakDevice::mask(const spec::Fields& fields, Instant now) {
  const unsigned address = fields.writes->first;
  const unsigned before = registers_.read(Table::holding_registers, address, now);
  const unsigned keep = fields.words[0];
  const unsigned set = fields.words[1];
  if (!is_live(Table::holding_registers, address)) {
    registers_.write(address, static_cast<std::uint16_t>((before & keep) | (set & ~keep)), now);
  }
}

void SoakDevice::write_registers(const spec::Fields& fields, Instant now) {
  const spec::Range& range = *fields.writes;
  for (unsigned at = 0; at < range.count; ++at) {
    const unsigned address = range.first + at;
    const bool whole =
        is_in_pair(range.table, address) && pair_of(address) == address && at + 1 < range.count;
    if (whole) {
      registers_.write_pair(address, std::uint32_t{fields.words[at]} << 16U | fields.words[at + 1],
                            now);
      ++at;
    } else if (!is_live(range.table, address)) {
      registers_.write(address, fields.words[at], now);
    }
  }
}

}  // namespace mbgate::soak

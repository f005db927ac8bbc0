// SPDX-License-Identifier: Apache-2.0
#include "soak/device.hpp"

#include <array>

#include "modbus/response.hpp"

namespace mbgate::soak {

using modbus::Pdu;
using modbus::Request;

namespace {

bool is_within(const std::optional<modbus::AddressField>& field) {
  if (!field) {
    return true;
  }
  const Table table = field->range.table;
  const bool bits = table == Table::coils || table == Table::discrete_inputs;
  return drive::end_of(field->range) <= (bits ? kCoils : kRegisters);
}

}  // namespace

SoakDevice::Outcome SoakDevice::carry_out(const Pdu& pdu, Instant now) {
  const auto request = Request::parse(pdu);
  if (!request) {
    return {Pdu::exception(pdu.function(), request.error())};
  }
  if (!is_within(request->reads()) || !is_within(request->writes())) {
    return {Pdu::exception(pdu.function(), modbus::ExceptionCode::illegal_data_address)};
  }
  if (request->writes()) {
    write(*request, now);
    if (settings_.silent_after(*request)) {
      die_until(now + *settings_.silent_after(*request));
      return {};
    }
  }
  return {answer_to(*request, now), is_slow(pdu.bytes())};
}

Pdu SoakDevice::answer_to(const Request& request, Instant now) const {
  if (request.reads()) {
    return read(request, now);
  }
  if (request.function() == 0x11 || request.function() == 0x2B) {
    return identify(request, now);
  }
  if (request.function() == kOwnFunction && request.pdu().bytes()[1] != kKnownCommand) {
    return Pdu::exception(kOwnFunction, modbus::ExceptionCode::illegal_function);
  }
  return modbus::echo_response(request);
}

// 17 and 43/14: nobody knows before how much it is. Input registers, so that it can be told when it
// was asked, and of whom.
Pdu SoakDevice::identify(const Request& request, Instant now) const {
  const auto value = [&](unsigned at) { return registers_.read(Table::input_registers, at, now); };
  const auto low = [](unsigned word) { return static_cast<std::uint8_t>(word & 0xFFU); };
  const unsigned count = 1U + value(0) % kMostIdentity;
  std::vector<std::uint8_t> bytes{0x11, low(2 * count)};
  if (request.function() == 0x2B) {
    bytes = {0x2B, 0x0E, 0x01, 0x01, 0, 0, low(count)};
  }
  for (unsigned at = 0; at < count; ++at) {
    if (request.function() == 0x2B) {
      bytes.push_back(low(at));
      bytes.push_back(2);
    }
    bytes.push_back(low(value(at) >> 8U));
    bytes.push_back(low(value(at)));
  }
  return *Pdu::from(bytes);
}

Pdu SoakDevice::read(const Request& request, Instant now) const {
  const modbus::TableRange& range = request.reads()->range;
  std::array<std::uint8_t, modbus::kMaxPduSize> bytes{};
  bytes[0] = request.function();
  const bool bits = range.table == Table::coils || range.table == Table::discrete_inputs;
  const std::size_t size = bits ? (range.count + 7U) / 8U : range.count * 2U;
  bytes[1] = static_cast<std::uint8_t>(size);
  for (unsigned at = 0; at < range.count; ++at) {
    const unsigned value = registers_.read(range.table, range.first + at, now);
    if (bits) {
      bytes[2 + at / 8] = static_cast<std::uint8_t>(bytes[2 + at / 8] | (value << (at % 8)));
    } else {
      modbus::store_be16(bytes, 2 + 2 * std::size_t{at}, static_cast<std::uint16_t>(value));
    }
  }
  return *Pdu::from(modbus::Bytes(bytes).first(2 + size));
}

void SoakDevice::write(const Request& request, Instant now) {
  const modbus::TableRange& range = request.writes()->range;
  if (request.function() == 0x16) {
    mask(request, now);
  } else if (range.table == Table::holding_registers) {
    write_registers(request, now);
  } else {
    for (std::uint32_t at = range.first; at < drive::end_of(range); ++at) {
      registers_.write_coil(at, request.written(static_cast<std::uint16_t>(at)) != 0, now);
    }
  }
}

void SoakDevice::mask(const Request& request, Instant now) {
  const modbus::Bytes bytes = request.pdu().bytes();
  const std::uint16_t address = request.writes()->range.first;
  const unsigned before = registers_.read(Table::holding_registers, address, now);
  const unsigned keep = spec::word_at(bytes, 3);
  const unsigned set = spec::word_at(bytes, 5);
  if (!is_live(Table::holding_registers, address)) {
    registers_.write(address, static_cast<std::uint16_t>((before & keep) | (set & ~keep)), now);
  }
}

void SoakDevice::write_registers(const Request& request, Instant now) {
  const modbus::TableRange& range = request.writes()->range;
  for (std::uint32_t at = range.first; at < drive::end_of(range); ++at) {
    const auto address = static_cast<std::uint16_t>(at);
    const bool whole =
        is_in_pair(range.table, at) && pair_of(at) == at && at + 1 < drive::end_of(range);
    if (whole) {
      registers_.write_pair(at,
                            (std::uint32_t{*request.written(address)} << 16U) |
                                *request.written(static_cast<std::uint16_t>(at + 1)),
                            now);
      ++at;
    } else if (!is_live(range.table, at)) {
      registers_.write(at, *request.written(address), now);
    }
  }
}

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
#include "soak/device.hpp"

#include <array>

#include "modbus/response.hpp"

namespace mbgate::soak {

using modbus::Pdu;
using modbus::Request;

SoakDevice::Outcome SoakDevice::carry_out(const Pdu& pdu, Instant now) {
  const auto request = Request::parse(pdu);
  if (!request) {
    return {Pdu::exception(pdu.function(), request.error())};
  }
  const auto& range = request->writes() ? request->writes()->range : request->reads()->range;
  const std::uint32_t limit =
      range.table == Table::coils || range.table == Table::discrete_inputs ? kCoils : kRegisters;
  if (drive::end_of(range) > limit) {
    return {Pdu::exception(pdu.function(), modbus::ExceptionCode::illegal_data_address)};
  }
  if (request->writes()) {
    write(*request, now);
    if (settings_.silent_after(*request)) {
      die_until(now + *settings_.silent_after(*request));
      return {};
    }
    return {modbus::echo_response(*request), range.first >= kSlowFrom};
  }
  return {read(*request, now)};
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
  if (range.table != Table::holding_registers) {
    return;
  }
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

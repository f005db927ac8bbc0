// SPDX-License-Identifier: Apache-2.0
#include "routing/address_window.hpp"

namespace mbgate::routing {
namespace {

bool lies_within(const AddressWindow& window, const modbus::TableRange& range) {
  return range.table == window.table && range.first >= window.from &&
         std::uint32_t{range.first} + range.count <= std::uint32_t{window.from} + window.count;
}

std::optional<std::uint16_t> moved(const AddressWindow& window,
                                   const std::optional<modbus::AddressField>& field) {
  if (!field) {
    return std::nullopt;
  }
  return static_cast<std::uint16_t>(field->range.first - window.from + window.to);
}

bool repeats_address(std::uint8_t function) {
  return function == 0x05 || function == 0x06 || function == 0x0F || function == 0x10 ||
         function == 0x16;
}

}  // namespace

std::optional<modbus::Request> through_window(const AddressWindow& window,
                                              const modbus::Request& request) {
  const auto& reads = request.reads();
  const auto& writes = request.writes();
  if ((reads && !lies_within(window, reads->range)) ||
      (writes && !lies_within(window, writes->range))) {
    return std::nullopt;
  }
  return request.with_addresses(moved(window, reads), moved(window, writes));
}

modbus::Pdu back_through_window(const modbus::Request& client_request,
                                const modbus::Pdu& response) {
  modbus::Pdu answer = response;
  if (repeats_address(answer.function())) {
    answer.set_be16(1, client_request.writes()->range.first);
  }
  return answer;
}

}  // namespace mbgate::routing

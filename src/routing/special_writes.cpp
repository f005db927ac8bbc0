// SPDX-License-Identifier: Apache-2.0
#include "routing/special_writes.hpp"

#include <algorithm>

#include "drive/word_order.hpp"

namespace mbgate::routing {
namespace {

using modbus::Request;
using modbus::Table;
using modbus::TableRange;

constexpr std::size_t kMultipleWriteData = 6;  // offset in the PDU (6.12)
constexpr std::size_t kReadWriteData = 10;     // (6.17)

bool writes_position_opcode(const drive::Device& device, const Request& request) {
  const auto& opcodes = device.profile.position_opcodes;
  const auto opcode = opcodes ? request.written(opcodes->address) : std::nullopt;
  return opcode && std::ranges::find(opcodes->opcodes, *opcode) != opcodes->opcodes.end();
}

bool writes_position(const drive::Device& device, const Request& request) {
  const std::uint16_t position = device.profile.position_opcodes->position;
  return request.written(position) && request.written(static_cast<std::uint16_t>(position + 1));
}

}  // namespace

bool touches_value(const drive::Device& device, const Request& request) {
  const auto holds = [&](const std::optional<modbus::AddressField>& field) {
    return field && device.profile.values.any_in(field->range);
  };
  return holds(request.reads()) || holds(request.writes());
}

bool cuts_value(const drive::Device& device, const TableRange& range) {
  const auto is_inside = [&](std::uint32_t border) {
    const drive::Value* value = device.profile.values.at(range.table, border);
    return value != nullptr && value->first < border;
  };
  return is_inside(range.first) || is_inside(drive::end_of(range));
}

bool has_uncertain_position(const drive::Device& device, drive::WordOrder seen,
                            const Request& request) {
  if (!writes_position_opcode(device, request)) {
    return false;
  }
  if (!device.opcode_order) {
    return device.word_order && *device.word_order != seen;
  }
  // A position that was written before cannot be exchanged any more.
  return *device.opcode_order != seen && !writes_position(device, request);
}

std::vector<std::uint8_t> data_in_order(const drive::Device& device,
                                        std::optional<drive::WordOrder> seen,
                                        const Request& request) {
  const std::size_t offset = request.function() == 0x17 ? kReadWriteData : kMultipleWriteData;
  const modbus::Bytes bytes = request.pdu().bytes().subspan(offset);
  std::vector<std::uint8_t> data(bytes.begin(), bytes.end());
  const TableRange& range = request.writes()->range;
  if (seen && device.word_order && *seen != *device.word_order) {
    drive::WordExchange(device.profile.values, range).apply(data);
  }
  const bool other_position = seen && device.opcode_order && *device.opcode_order != *seen;
  if (other_position && writes_position_opcode(device, request) &&
      writes_position(device, request)) {
    drive::ValueSet position;
    position.add({Table::holding_registers, device.profile.position_opcodes->position});
    drive::WordExchange(position, range).apply(data);
  }
  return data;
}

}  // namespace mbgate::routing

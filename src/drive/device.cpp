// SPDX-License-Identifier: Apache-2.0
#include "drive/device.hpp"

namespace mbgate::drive {
namespace {

constexpr std::size_t kMultipleWriteData = 6;  // offset in the PDU (6.12)
constexpr std::size_t kReadWriteData = 10;     // (6.17)

// A masked write (22) may make any opcode.
bool writes_position_opcode(const Device& device, const modbus::Request& request) {
  const auto& opcodes = device.profile.position_opcodes;
  constexpr auto kHolding = modbus::Table::holding_registers;
  if (!opcodes || !request.writes() ||
      !contains(request.writes()->range, kHolding, opcodes->address)) {
    return false;
  }
  const auto opcode = request.written(opcodes->address);
  return !opcode || std::ranges::find(opcodes->opcodes, *opcode) != opcodes->opcodes.end();
}

bool writes_position(const Device& device, const modbus::Request& request) {
  const std::uint16_t position = device.profile.position_opcodes->position;
  return request.written(position) && request.written(static_cast<std::uint16_t>(position + 1));
}

}  // namespace

DeviceTiming Device::timing_of(const modbus::Request& request) const {
  DeviceTiming times = timing;
  const auto meets = [&](const SlowRegisters& slow, const std::optional<modbus::AddressField>& at) {
    return at && overlap(slow.range,
                         {profile.described_in(at->range.table), at->range.first, at->range.count});
  };
  for (const SlowRegisters& slow : profile.slow) {
    if (meets(slow, request.reads()) || meets(slow, request.writes())) {
      times.response_timeout = std::max(times.response_timeout, slow.response_timeout);
    }
  }
  return times;
}

bool Device::is_reconfigured_by(const modbus::Request& request,
                                std::optional<WordOrder> order) const {
  return request.writes() &&
         (touches(profile.communication, request.writes()->range) ||
          std::ranges::any_of(profile.guarded, [&](const GuardedWrite& guarded) {
            return may_write(request, guarded, order);
          }));
}

// The parameters of a stop are right behind it, so the first register is always a stop.
bool Device::is_stop(const modbus::Request& request) const {
  if (request.reads() || !request.writes()) {
    return false;
  }
  const modbus::TableRange& range = request.writes()->range;
  std::uint32_t parameters_end = range.first;
  for (std::uint32_t at = range.first; at < end_of(range); ++at) {
    if (const WriteMatch* stop = stop_at(request, at)) {
      parameters_end = std::max(parameters_end, at + 1U + stop->parameters);
    } else if (at >= parameters_end) {
      return false;
    }
  }
  return true;
}

const WriteMatch* Device::stop_at(const modbus::Request& request, std::uint32_t place) const {
  const WriteMatch* found = nullptr;
  for (const WriteMatch& stop : profile.stops) {
    const bool stops = stop.address == place && writes(request, stop);
    found = stops && (found == nullptr || stop.parameters > found->parameters) ? &stop : found;
  }
  return found;
}

bool Device::may_be_stopped_by(const modbus::Request& request) const {
  return request.writes() && std::ranges::any_of(profile.stops, [&](const WriteMatch& stop) {
           const auto written = request.written(stop.address);
           return contains(request.writes()->range, stop.table, stop.address) &&
                  (!written || stop.fits(*written));
         });
}

const std::vector<std::uint16_t>* Device::stated_order() const {
  const auto& setting = profile.word_order_register;
  if (!setting) {
    return nullptr;
  }
  return word_order == WordOrder::big ? &setting->big : &setting->little;
}

bool Device::takes_limited(const modbus::Request& request, modbus::Bytes response) const {
  constexpr std::size_t kAddressed = 3;  // function and address (6.5, 6.6)
  const modbus::Bytes asked = request.pdu().bytes();
  return limits_values && (request.function() == 5 || request.function() == 6) &&
         response.size() == asked.size() &&
         std::ranges::equal(response.first(kAddressed), asked.first(kAddressed));
}

std::optional<Duration> Device::silent_after(const modbus::Request& request) const {
  for (const UnansweredWrite& unanswered : profile.unanswered) {
    if (writes(request, unanswered.match)) {
      return unanswered.after;
    }
  }
  return std::nullopt;
}

bool Device::writes_value(const modbus::Request& request) const {
  return request.writes() && profile.values.any_in(request.writes()->range);
}

bool Device::cuts_value(const modbus::TableRange& range) const {
  const auto is_inside = [&](std::uint32_t border) {
    const Value* value = profile.values.at(range.table, border);
    return value != nullptr && value->first < border;
  };
  return is_inside(range.first) || is_inside(end_of(range));
}

bool Device::has_uncertain_position(WordOrder seen, const modbus::Request& request) const {
  if (!writes_position_opcode(*this, request)) {
    return false;
  }
  if (!opcode_order) {
    return word_order && *word_order != seen;
  }
  // A position that was written before cannot be exchanged any more.
  return *opcode_order != seen && !writes_position(*this, request);
}

std::vector<std::uint8_t> Device::data_in_order(std::optional<WordOrder> seen,
                                                const modbus::Request& request) const {
  const std::size_t offset = request.function() == 0x17 ? kReadWriteData : kMultipleWriteData;
  const modbus::Bytes bytes = request.pdu().bytes().subspan(offset);
  std::vector<std::uint8_t> data(bytes.begin(), bytes.end());
  const modbus::TableRange& range = request.writes()->range;
  if (seen && word_order && *seen != *word_order) {
    WordExchange(profile.values, range).apply(data);
  }
  const bool other_position = seen && opcode_order && *opcode_order != *seen;
  if (other_position && writes_position_opcode(*this, request) && writes_position(*this, request)) {
    ValueSet position;
    position.add({modbus::Table::holding_registers, profile.position_opcodes->position});
    WordExchange(position, range).apply(data);
  }
  return data;
}

}  // namespace mbgate::drive

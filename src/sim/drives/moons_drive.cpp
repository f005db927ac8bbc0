// SPDX-License-Identifier: Apache-2.0
#include "sim/drives/moons_drive.hpp"

#include <algorithm>
#include <array>

namespace mbgate::sim {
namespace {

// 5.1 and 5.3 (50 registers), Appendix 2 (codes).
constexpr RegisterRules kMoonsRules{.most_read = 50,
                                    .most_written = 50,
                                    .no_such_register = 0x02,
                                    .not_readable = 0x11,
                                    .not_writable = 0x12,
                                    .out_of_range = 0x13,
                                    .too_many = 0x03};

// Section 6.1, in ascending order.
constexpr std::array<std::uint16_t, 36> kOpcodes{
    0x06, 0x42, 0x46, 0x47, 0x54, 0x66, 0x67, 0x68, 0x69, 0x6A, 0x6B, 0x6C,
    0x6D, 0x6E, 0x6F, 0x70, 0x78, 0x8B, 0x96, 0x98, 0x9E, 0x9F, 0xA2, 0xA3,
    0xA5, 0xBA, 0xC0, 0xCC, 0xD1, 0xD2, 0xD3, 0xD6, 0xD8, 0xDB, 0xE1, 0xE2};
constexpr std::uint16_t kFeedToLength = 0x66;
constexpr std::uint16_t kFeedToPosition = 0x67;
constexpr std::uint16_t kSeekHome = 0x6E;
constexpr std::uint16_t kStartJogging = 0x96;
constexpr std::uint16_t kEncoderPosition = 0x98;
constexpr std::uint16_t kMotorDisable = 0x9E;
constexpr std::uint16_t kMotorEnable = 0x9F;
constexpr std::uint16_t kSetPosition = 0xA5;
constexpr std::uint16_t kAlarmReset = 0xBA;
constexpr std::uint16_t kStopJogging = 0xD8;
constexpr std::uint16_t kFindHome = 0xDB;
constexpr std::uint16_t kStopMaximum = 0xE1;
constexpr std::uint16_t kStopNormal = 0xE2;

// Status code, Appendix 6.
constexpr std::uint32_t kEnabled = 0x0001;
constexpr std::uint32_t kInPosition = 0x0008;
constexpr std::uint32_t kRunning = 0x0010;
constexpr std::uint32_t kJogging = 0x0020;

// The register may be one of two, where the series has values.
bool touches_value(const modbus::TableRange& range, std::uint16_t first) {
  return touches(range, first) || touches(range, static_cast<std::uint16_t>(first + 1));
}

}  // namespace

MoonsDrive::MoonsDrive(MoonsSeries series, drive::WordOrder order)
    : places_(moons_places(series)), order_(order), registers_(moons_registers(series), order) {
  if (places_.protocol && order == drive::WordOrder::little) {
    registers_.set(*places_.protocol, kMoonsProtocolLittle);
  }
}

Reaction MoonsDrive::answer(const modbus::Pdu& pdu) {
  const auto request = request_of(pdu, {0x03, 0x06, 0x10});
  if (!request) {
    return request.error();
  }
  return {request->reads() ? serve_read(*request, registers_, kMoonsRules) : write(*request)};
}

Reaction MoonsDrive::hear_broadcast(const modbus::Pdu& pdu) {
  if (pdu.function() == 0x06 || pdu.function() == 0x10) {
    answer(pdu);
  }
  return {};
}

modbus::Pdu MoonsDrive::write(const modbus::Request& request) {
  if (!knows_opcode(request)) {
    return exception(request.function(), kMoonsRules.out_of_range);
  }
  const modbus::Pdu response = serve_write(request, registers_, kMoonsRules);
  if (response.is_exception()) {
    return response;
  }
  const modbus::TableRange& range = request.writes()->range;
  // 7.3: the opcode may come with its parameters in one request, so they must be in place first.
  if (touches(range, kMoonsOpcode)) {
    execute(static_cast<std::uint16_t>(registers_.get(kMoonsOpcode)));
  }
  if (places_.protocol && touches_value(range, *places_.protocol)) {
    take_word_order();
  }
  return response;
}

bool MoonsDrive::knows_opcode(const modbus::Request& request) const {
  const auto opcode = request.written(kMoonsOpcode);
  return !opcode || std::ranges::binary_search(kOpcodes, *opcode);
}

void MoonsDrive::execute(std::uint16_t opcode) {
  switch (opcode) {
    case kFeedToLength:
      registers_.set(places_.relative_distance, registers_.get(places_.distance));
      move_to(registers_.get(places_.position) + registers_.get(places_.distance));
      break;
    case kFeedToPosition: move_to(registers_.get(places_.distance)); break;
    case kSeekHome:
    case kFindHome: move_to(0); break;
    case kStartJogging: start_jogging(); break;
    case kStopJogging:
    case kStopMaximum:
    case kStopNormal: stand_still(); break;
    case kEncoderPosition: registers_.set(places_.encoder_position, position_parameter()); break;
    case kSetPosition: set_position(position_parameter()); break;
    case kMotorDisable:
      stand_still();
      change_status(kEnabled, 0);
      break;
    case kMotorEnable: change_status(0, kEnabled); break;
    case kAlarmReset: registers_.set(places_.alarm, 0); break;
    // Conditions, filters, outputs and queues are accepted and change nothing that a client can
    // see.
    default: break;
  }
}

void MoonsDrive::stand_still() {
  registers_.set(places_.velocity, 0);
  registers_.set(places_.target_velocity, 0);
  change_status(kRunning | kJogging, kInPosition);
}

void MoonsDrive::move_to(std::uint32_t position) {
  stand_still();
  set_position(position);
  registers_.set(places_.encoder_position, position);
}

void MoonsDrive::set_position(std::uint32_t position) {
  if (places_.position_command) {
    registers_.set(*places_.position_command, position);
  }
  registers_.set(places_.position, position);
}

void MoonsDrive::start_jogging() {
  registers_.set(places_.velocity, registers_.get(places_.jog_velocity));
  registers_.set(places_.target_velocity, registers_.get(places_.jog_velocity));
  change_status(kInPosition, kRunning | kJogging);
}

void MoonsDrive::take_word_order() {
  const bool little = (registers_.get(*places_.protocol) & kMoonsLittleBit) != 0;
  order_ = little ? drive::WordOrder::little : drive::WordOrder::big;
  registers_.set_word_order(order_);
}

// The manual does not state the order of these two registers; the drive's own is the obvious guess.
std::uint32_t MoonsDrive::position_parameter() const {
  const auto first = static_cast<std::uint16_t>(registers_.get(kMoonsParameters));
  const auto second = static_cast<std::uint16_t>(registers_.get(kMoonsParameters + 1));
  return drive::from_registers({first, second}, order_);
}

void MoonsDrive::change_status(std::uint32_t clear, std::uint32_t set) {
  const std::uint32_t status = (registers_.get(places_.status) & ~clear) | set;
  registers_.set(places_.status, status & places_.status_bits);
}

}  // namespace mbgate::sim

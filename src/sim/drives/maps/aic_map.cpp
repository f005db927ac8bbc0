// SPDX-License-Identifier: Apache-2.0
#include "sim/drives/maps/aic_map.hpp"

#include <algorithm>
#include <array>

namespace mbgate::sim {
namespace {

using modbus::Table;
using enum Access;
using enum Width;

constexpr Limits kSpeed{1, 600000};
constexpr Limits kTime{1, 10000};
constexpr Limits kRamp{0, 10000};
constexpr Limits kPulseWidth{1, 1000};
constexpr Limits kCompareMode{0, 3};
constexpr Limits kSixteen{0, 15};
constexpr Limits kTorquePercent{20, 100};

constexpr std::array kCoils{RegisterRun{0x0000, 10, word, read_write, 0, kSwitch},
                            RegisterRun{0x000A, 17, word, write_only, 0, kSwitch},
                            RegisterRun{0x001E, 36, word, read_write, 0, kSwitch}};

constexpr std::array kDiscreteInputs{RegisterRun{0x0000, 28, word, read_only},
                                     RegisterRun{0x001C, 1, word, read_only, 1},  // servo on
                                     RegisterRun{0x001D, 1, word, read_only},     // alarm
                                     RegisterRun{0x001E, 1, word, read_only, 1},  // in position
                                     RegisterRun{0x001F, 2, word, read_only}};    // comparisons

constexpr std::array kInputRegisters{
    RegisterRun{0x0064, 2, word, read_only, 1},       // serial number
    RegisterRun{0x0066, 2, word, read_only, 0x0100},  // hardware and software version
    RegisterRun{0x0068, 1, word, read_only, 0x4169},  // model name: "Ai"
    RegisterRun{0x0069, 1, word, read_only, 0x432D},  // "C-"
    RegisterRun{0x006A, 1, word, read_only, 0x442D},  // "D-"
    RegisterRun{0x006B, 1, word, read_only, 0x3536},  // "56"
    RegisterRun{0x006C, 1, word, read_only, 0x4C41},  // "LA"
    RegisterRun{0x006D, 8, word, read_only},          // reserved
    RegisterRun{0x0075, 1, word, read_only,
                0x0000},  // where each table starts, and how much it has
    RegisterRun{0x0076, 1, word, read_only, 100},
    RegisterRun{0x0077, 1, word, read_only, 0x0000},
    RegisterRun{0x0078, 1, word, read_only, 100},
    RegisterRun{0x0079, 1, word, read_only, 0x0002},
    RegisterRun{0x007A, 1, word, read_only, 5202},
    RegisterRun{0x007B, 1, word, read_only, 0x0064},
    RegisterRun{0x007C, 1, word, read_only, 915},
    RegisterRun{0x03E7, 1, word, read_only},           // run mode
    RegisterRun{0x03E8, 4, value, read_only},          // positions and speeds
    RegisterRun{0x03F0, 6, word, read_only},           // motor speed, step, errors, inputs
    RegisterRun{0x03F6, 1, word, read_only, 0x0012}};  // in position, servo on

constexpr std::array kHoldingRegisters{
    RegisterRun{0x0002, 2, value, read_write, 1000, kSpeed},  // start and final speed
    RegisterRun{0x0006, 2, word, read_write, 100, kRamp},     // acceleration and deceleration time
    RegisterRun{0x0008, 1, value, read_write},                // position to move
    RegisterRun{0x000A, 1, word, read_write, 0, Limits{0, 255}},
    RegisterRun{0x000B, 1, word, read_write, 0, Limits{0, 3}},
    RegisterRun{kAicFirstStep, kAicStepRegisters, word, read_write},
    RegisterRun{kAicSettingBits, 3, word, read_write},
    RegisterRun{0x13BA, 2, value, read_write, 1000},                // home search speeds
    RegisterRun{0x13BE, 2, word, read_write, 100, kTime},           // and times
    RegisterRun{0x13C0, 1, word, read_write, 0, kSwitch},           // direction
    RegisterRun{0x13C1, 2, value, read_write},                      // offset, zero
    RegisterRun{0x13C5, 1, word, read_write, 0, kSwitch},           // sensor level
    RegisterRun{0x13C6, 1, word, read_write, 100, kTorquePercent},  // torque
    RegisterRun{0x13EE, 10, value, read_write, 1000},               // running speeds
    RegisterRun{0x1402, 5, word, read_write, 100, kTime},           // waiting times
    RegisterRun{0x1407, 10, word, read_write, 100, kRamp},  // acceleration, deceleration times
    RegisterRun{0x1411, 1, word, read_write, 100, Limits{1, 5000}},
    RegisterRun{0x1412, 2, value, read_write},                  // software limits
    RegisterRun{0x1416, 5, word, read_write, 100, kTime},       // on times
    RegisterRun{0x141B, 1, word, read_write, 0, kCompareMode},  // comparison 1
    RegisterRun{0x141C, 1, word, read_write, 1, kPulseWidth},
    RegisterRun{0x141D, 2, value, read_write},
    RegisterRun{0x1421, 1, word, read_write, 0, kCompareMode},  // comparison 2
    RegisterRun{0x1422, 1, word, read_write, 1, kPulseWidth},
    RegisterRun{0x1423, 2, value, read_write},
    RegisterRun{0x1427, 1, word, read_write, 0, Limits{0, 9}},  // pulses a turn
    RegisterRun{0x1428, 1, word, read_write, 0, kSixteen},
    RegisterRun{0x1429, 1, word, read_write, 50, kTorquePercent},
    RegisterRun{0x142A, 2, word, read_write, 0, kSixteen},
    RegisterRun{0x142C, 1, word, read_write, 0, Limits{0, 7000}},
    RegisterRun{0x142D, 1, word, read_write, 0, Limits{0, 4000}},
    RegisterRun{0x1450, 1, word, read_write, 0, Limits{0, 4}},  // baud rate
    RegisterRun{0x1451, 1, word, read_write, 0, Limits{0, 2}},  // parity
    RegisterRun{0x1452, 1, word, read_write, 0, kSwitch},       // stop bits
    RegisterRun{kAicResponseWait, 1, word, read_write, 1, Limits{1, 99}}};

struct Group {
  Table table;
  std::uint16_t first;
  std::uint16_t last;
};

// One for each of the sections 2.1 to 2.12, with the places that it lists as reserved: 2.13 forbids
// to leave a group, and these are in it. A request for them gets 02, as for any that is not there.
constexpr std::array kGroups{
    Group{Table::coils, 0x0000, 0x0009},
    Group{Table::coils, kAicFirstCommand, 0x001D},
    Group{Table::coils, kAicFirstSetting, 0x0063},
    Group{Table::discrete_inputs, 0x0000, 0x0063},
    Group{Table::input_registers, 0x0000, 0x03E6},
    Group{Table::input_registers, 0x03E7, 0x0419},
    Group{Table::holding_registers, 0x0000, 0x0031},
    Group{Table::holding_registers, kAicFirstStep, kAicFirstStep + kAicStepRegisters - 1},
    Group{Table::holding_registers, kAicSettingBits, 0x13B9},
    Group{Table::holding_registers, 0x13BA, 0x13EB},
    Group{Table::holding_registers, 0x13EC, 0x144F},
    Group{Table::holding_registers, kAicFirstCommunication, 0x1481}};

}  // namespace

RegisterMap aic_registers(Table table) {
  switch (table) {
    case Table::coils: return kCoils;
    case Table::discrete_inputs: return kDiscreteInputs;
    case Table::holding_registers: return kHoldingRegisters;
    case Table::input_registers: return kInputRegisters;
  }
  return {};
}

std::optional<bool> aic_stays_in_group(const modbus::TableRange& range) {
  const auto* group = std::ranges::find_if(kGroups, [&range](const Group& candidate) {
    return candidate.table == range.table && range.first >= candidate.first &&
           range.first <= candidate.last;
  });
  if (group == kGroups.end()) {
    return std::nullopt;
  }
  return range.first + range.count - 1 <= group->last;
}

}  // namespace mbgate::sim

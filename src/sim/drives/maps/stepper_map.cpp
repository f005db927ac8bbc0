// SPDX-License-Identifier: Apache-2.0
#include "sim/drives/maps/stepper_map.hpp"

#include <array>

namespace mbgate::sim {
namespace {

using enum Access;
using enum Width;

// A string is read low word first and low byte first: "170" is 37 31 00 30 on the wire (manual line
// 242).
constexpr std::uint32_t kHardware170 = 0x00303731;
constexpr std::uint32_t kSoftware105 = 0x00353031;
constexpr std::uint32_t kFarthest = 0x7FFFFFFF;          // software limits
constexpr std::uint32_t kNearest = 0x80000000;           // software limits
constexpr std::uint32_t kPositionReminder = 1073741823;  // 0x00C2 to 0x00C7
constexpr Limits kTargetSpeed{-999999, 999999};          // 0x00D8, manual line 1844 ff.

constexpr std::array kStepperRegisters{
    RegisterRun{0x0000, 1, value, read_only, kHardware170},
    RegisterRun{0x0002, 1, value, read_only, kSoftware105},
    RegisterRun{0x0004, 1, value, read_only},               // position
    RegisterRun{0x0006, 1, value, read_only, kAtPosition},  // status
    RegisterRun{0x0008, 1, word, read_write},               // serial time-out
    RegisterRun{0x0009, 1, word, read_write, 12},           // communication parameters
    RegisterRun{0x000A, 1, word, read_write, 250},          // smoothing
    RegisterRun{0x000B, 1, word, read_write, 200},          // dynamic error alarm
    RegisterRun{0x000C, 1, word, read_write, 100},          // static error alarm
    RegisterRun{0x000D, 1, word, read_write, 100},          // rated current
    RegisterRun{0x000E, 1, word, read_write, 50},           // idle current
    RegisterRun{0x000F, 1, word, read_write, 1000},         // encoder lines
    RegisterRun{0x0010, 1, word, read_write, 20},           // deviation warning
    RegisterRun{0x0011, 1, word, read_only},                // deviation
    RegisterRun{0x0012, 2, word, read_write},               // shielding, filter
    RegisterRun{0x0015, 1, word, read_only},                // program position
    RegisterRun{0x0016, 1, word, read_write},               // dynamic maximum speed
    RegisterRun{0x0017, 1, word, read_write, 200},          // encoder lines at least
    RegisterRun{0x0018, 1, word, read_write},               // brake
    RegisterRun{0x0019, 2, word, read_only},                // speed, current
    RegisterRun{0x001B, 8, word, read_write, 2},            // input delays
    RegisterRun{0x0024, 1, value, read_write, 4000},        // microsteps
    RegisterRun{0x0026, 3, word, read_write},               // motor
    RegisterRun{0x0029, 1, word, read_write, 100},          // position integral
    RegisterRun{0x002C, 8, word, read_write, 30},           // DIP switch speeds
    RegisterRun{0x0044, 5, word, read_write},               // extremes
    RegisterRun{0x0066, 1, word, read_write, 1},            // base address
    RegisterRun{0x0067, 1, word, read_write},               // address source
    RegisterRun{0x006B, 1, word, read_write},               // direction
    RegisterRun{0x006C, 1, word, write_only},               // port level
    RegisterRun{0x006D, 1, word, read_write},               // limits valid
    RegisterRun{0x006E, 1, value, read_write, kNearest},    // negative software limit
    RegisterRun{0x0070, 1, value, read_write, kFarthest},   // positive software limit
    RegisterRun{0x0075, 1, word, read_write},               // program pointer
    RegisterRun{0x0076, 1, value, read_only},               // program counter
    RegisterRun{0x0078, 2, value, read_write},              // program maximum, origin offset
    RegisterRun{0x0096, 2, word, read_write, 50},           // start and stop speed
    RegisterRun{0x0098, 2, word, read_write, 120},          // acceleration and deceleration
    RegisterRun{0x009A, 1, word, read_write, 300},          // run speed
    RegisterRun{0x009B, 4, word, read_write},               // ports, homing, torque
    RegisterRun{0x009F, 1, word, read_write, 3},            // running mode
    RegisterRun{0x00A0, 2, word, write_only},               // outputs
    RegisterRun{0x00A2, 2, word, read_only},                // outputs, alarms
    RegisterRun{0x00A4, 1, word, write_only},               // clear alarms
    RegisterRun{0x00A5, 1, word, read_write, 257},          // alarm output
    RegisterRun{0x00A6, 2, word, read_write, 514},          // dynamic and in-position output
    RegisterRun{0x00A8, 1, value, read_write},              // position reminder X11
    RegisterRun{0x00AA, 12, word, read_write},              // table, inputs, change speeds
    RegisterRun{0x00B6, 1, value, read_write},              // dynamic positioning
    RegisterRun{0x00B8, 1, word, read_write},               // change speed 4
    RegisterRun{0x00BA, 1, value, read_write},              // port functions
    RegisterRun{0x00BE, 1, word, read_write},               // rotor offset
    RegisterRun{0x00BF, 1, word, read_write, 100},          // position proportion
    RegisterRun{0x00C0, 1, word, read_write, 3200},         // speed proportion
    RegisterRun{0x00C1, 1, word, read_write, 25},           // speed integral
    RegisterRun{0x00C2, 3, value, read_write, kPositionReminder},
    RegisterRun{0x00C8, 4, word, write_only},   // run, homing, jog, torque
    RegisterRun{0x00CC, 3, value, write_only},  // motion
    RegisterRun{0x00D2, 1, value, read_write},  // listed RO (line 204), written in line 1992
    RegisterRun{0x00D4, 1, word, write_only},   // release, enable, restart
    RegisterRun{0x00D5, 1, word, read_only},    // given speed
    RegisterRun{0x00D6, 1, value, read_only},   // real speed
    RegisterRun{0x00D8, 1, value, read_write, 30000, kTargetSpeed},
    RegisterRun{0x00DB, 1, word, write_only},              // program
    RegisterRun{0x00DC, 1, word, write_only, 0, kSwitch},  // save, restore
    RegisterRun{0x00DD, 1, word, write_only},              // table
    RegisterRun{0x00DE, 1, value, write_only},             // motion at any time
    RegisterRun{0x00E8, 1, value, write_only},             // motion at any time
    RegisterRun{0x012C, 4096, word, read_write}};          // programs and tables, from 300 on

}  // namespace

RegisterMap stepper_registers() { return kStepperRegisters; }

}  // namespace mbgate::sim

// SPDX-License-Identifier: Apache-2.0
#include "sim/moons_map.hpp"

#include <array>

namespace mbgate::sim {
namespace {

using enum Access;
using enum Width;

// The manual prints no ranges in these tables. The product's own are wider than they are
// interesting; what counts here is that a velocity or acceleration of 0 is out of range.
constexpr Limits kRate{1, 32000};

// Both series agree in 40001 to 40035, but for the access to 40009..10.
constexpr RegisterRun kAlarm{0x0000, 1, word, read_only};
constexpr RegisterRun kStatus{0x0001, 1, word, read_only,
                              0x0009};  // enabled, in position (Appendix 6)
constexpr RegisterRun kInputs{0x0002, 2, word, read_only};
constexpr RegisterRun kPositions{0x0004, 2, value, read_only};  // encoder, immediate absolute
constexpr RegisterRun kVelocities{0x000A, 2, word, read_only};
constexpr RegisterRun kTemperature{0x000C, 1, word, read_only, 400};  // 0.1 degrees
constexpr RegisterRun kBusVoltage{0x000D, 1, word, read_only, 240};   // 0.1 V
constexpr RegisterRun kPositionError{0x000E, 1, value, read_only};
constexpr RegisterRun kAnalogToCurrent{0x0010, 3, word, read_only};
constexpr RegisterRun kDistanceAndSensor{0x0013, 2, value, read_only};
constexpr RegisterRun kConditionToMode{0x0017, 4, word, read_only};
constexpr RegisterRun kPointToPoint{0x001B, 3, word, read_write, 240, kRate};  // AC, DE, VE
constexpr RegisterRun kDistances{0x001E, 2, value, read_write};                // DI, DC
constexpr RegisterRun kChangeVelocity{0x0022, 1, word, read_write, 240, kRate};
constexpr RegisterRun kStates{0x0023, 5, word, read_only};
constexpr RegisterRun kPositionOffset{0x0028, 1, value, read_write};
constexpr RegisterRun kFlags{0x002A, 2, word, read_write};
constexpr RegisterRun kInputCounter{0x002C, 1, value, read_write};
constexpr RegisterRun kJog{0x002E, 3, word, read_write, 240, kRate};  // JA, JL, JS

// Manual lines 1244 to 1336.
constexpr std::array kSt{
    kAlarm, kStatus, kInputs, kPositions, RegisterRun{0x0008, 1, value, read_only},  // SP
    kVelocities, kTemperature, kBusVoltage, kPositionError, kAnalogToCurrent, kDistanceAndSensor,
    kConditionToMode, kPointToPoint, kDistances, kChangeVelocity, kStates, kPositionOffset, kFlags,
    kInputCounter, kJog, RegisterRun{0x0031, 4, word, read_write},
    RegisterRun{0x0035, 1, value, read_write},   // pulse counter
    RegisterRun{0x0037, 3, word, read_write},    // analog gain, threshold, offset
    RegisterRun{0x003A, 23, value, read_write},  // accumulator, user registers 1 to 22
    RegisterRun{0x0068, 3, word, read_write},    // brake and idle current delays
    RegisterRun{0x006B, 2, word, read_only},     // reserved
    RegisterRun{0x006D, 1, word, read_write},    // analog filter gain
    // Printed as LONG, but a reserved block is no value.
    RegisterRun{0x006E, 14, word, read_only},
    RegisterRun{0x007C, 6, word, read_write}};  // opcode and five parameters

// Manual lines 1840 to 2027.
constexpr std::array kM2{
    kAlarm,
    kStatus,
    kInputs,
    kPositions,
    RegisterRun{0x0008, 1, value, write_only},  // SP (line 1850)
    kVelocities,
    kTemperature,
    kBusVoltage,
    kPositionError,
    kAnalogToCurrent,
    kDistanceAndSensor,
    kConditionToMode,
    kPointToPoint,
    kDistances,
    kChangeVelocity,
    kStates,
    kPositionOffset,
    kFlags,
    kInputCounter,
    kJog,
    RegisterRun{0x0031, 3, word, read_write},
    RegisterRun{0x0034, 1, word, read_only},     // reserved
    RegisterRun{0x0035, 1, value, read_write},   // pulse counter
    RegisterRun{0x0037, 3, word, read_write},    // analog gain, threshold, offset
    RegisterRun{0x003A, 1, value, read_only},    // accumulator
    RegisterRun{0x003C, 22, value, read_write},  // user registers
    RegisterRun{0x0068, 2, word, read_write},    // brake delays
    RegisterRun{0x006A, 3, word, read_only},     // reserved, firmware version
    RegisterRun{0x006D, 1, word, read_write},    // analog filter gain
    RegisterRun{0x006E, 2, word, read_only},     // reserved, high alarm word
    RegisterRun{0x0070, 12, word, read_write},   // jog changes, input filters
    RegisterRun{0x007C, 24, word, read_write},   // opcode, parameters, gains, modes
    RegisterRun{0x0094, 3, word, read_only},     // encoder resolution, reserved, steps
    RegisterRun{0x0097, 2, word, read_write},    // electronic ratio
    RegisterRun{0x0099, 1, word, read_only},     // step mode
    RegisterRun{0x009A, 21, word,
                read_write},                  // limits, analog settings, input and output functions
    RegisterRun{0x00AF, 1, word, read_only},  // reserved
    RegisterRun{0x00B0, 1, word, read_write, kMoonsProtocolBig},  // PR
    RegisterRun{0x00B1, 1, word, read_write, 0, Limits{0, 20}},   // TD, ms
    RegisterRun{0x00B2, 1, word, read_write, 5, Limits{1, 5}},    // BR: 115200
    RegisterRun{0x00B3, 1, word, read_write, 1, Limits{1, 32}},   // DA
    RegisterRun{0x00B4, 18, word, read_write},                    // display, homing, regeneration
    RegisterRun{0x00C6, 2, word, read_only}};                     // reserved

}  // namespace

RegisterMap moons_registers(MoonsSeries series) {
  switch (series) {
    case MoonsSeries::st: return kSt;
    case MoonsSeries::m2: return kM2;
  }
  return kSt;
}

}  // namespace mbgate::sim

// SPDX-License-Identifier: Apache-2.0
#include "sim/drives/maps/fda6000_map.hpp"

#include <array>

namespace mbgate::sim {
namespace {

using enum Access;
using enum Width;

constexpr Limits kPercent{0, 300};
constexpr Limits kMilliseconds{0, 10000};
constexpr Limits kTenthsOfPercent{-1000, 1000};
constexpr Limits kScale{10, 200};
constexpr Limits kUnsigned{0, 0xFFFF};
constexpr Limits kSigned{-32768, 32767};

// Where two ranges are printed, the second one is what fits into the register.
constexpr std::array kRegisters{
    // The examples of 6.2 and 6.3 write here, though the map begins with St-01.
    RegisterRun{0x0001, 2, word, read_write},
    RegisterRun{0x000A, 9, word, read_only},  // St-01 to St-09
    RegisterRun{0x0064, 1, word, read_write, 21, Limits{0, 99}},
    RegisterRun{0x0065, 6, word, read_only},
    RegisterRun{0x006B, 1, word, read_only, 555},  // P1-08, as the example of 6.1 reads it
    RegisterRun{0x006C, 1, word, read_write},
    RegisterRun{0x006D, 1, word, read_write, 10, Limits{0, 20}},
    RegisterRun{0x006E, 1, word, read_write, 0, Limits{0, 9}},
    RegisterRun{0x006F, 1, word, read_write, 2000, Limits{1, 10000}},
    RegisterRun{0x0070, 1, word, read_write, 0, kSwitch},  // P1-13: 1 to 1 would exclude its 0
    RegisterRun{0x0071, 1, word, read_write, 1, Limits{1, 31}},  // P1-14: the address
    RegisterRun{0x0072, 1, word, read_write, 0, kSwitch},
    RegisterRun{0x00C8, 1, word, read_write, 50, Limits{0, 500}},  // P2-01
    RegisterRun{0x00C9, 1, word, read_write, 0, Limits{0, 5000}},
    RegisterRun{0x00CA, 1, word, read_write, 1, Limits{1, 10000}},
    RegisterRun{0x00CB, 2, word, read_write, 300, kPercent},
    RegisterRun{0x00CD, 1, word, read_write, 0, Limits{1, 16}},
    RegisterRun{0x00CE, 1, word, read_write, 1, kSwitch},
    RegisterRun{0x00CF, 1, word, read_write, 500, kUnsigned},
    RegisterRun{0x00D0, 1, word, read_write, 10, kMilliseconds},
    RegisterRun{0x00D1, 1, word, read_write, 0, Limits{0, 2}},
    RegisterRun{0x00D2, 1, word, read_write, 0, kSwitch},
    RegisterRun{0x00D3, 1, word, read_write, 10, kScale},
    RegisterRun{0x00D4, 1, word, read_write, 0, kTenthsOfPercent},
    RegisterRun{0x00D5, 1, word, read_write, 1, Limits{0, 2}},
    RegisterRun{0x00D6, 1, word, read_write, 0, kSwitch},
    RegisterRun{0x00D7, 1, word, read_write, 10, kScale},
    RegisterRun{0x00D8, 1, word, read_write, 0, kTenthsOfPercent},
    RegisterRun{0x00D9, 1, word, read_write, 300, Limits{0, 1000}},
    RegisterRun{0x00DA, 1, word, read_write, 100, Limits{0, 1000}},
    RegisterRun{0x00DB, 1, word, read_write, 0, kSwitch},
    RegisterRun{0x00DC, 1, word, read_write, 10, Limits{10, 5000}},
    RegisterRun{0x00DD, 1, word, read_write, 0, Limits{0, 9}},
    RegisterRun{0x00DE, 1, word, read_write, 0, kSwitch},
    RegisterRun{kFdaParameterInit, 1, word, read_write, 0, kSwitch},
    RegisterRun{0x00E0, 1, word, read_write, 0, kSwitch},
    RegisterRun{0x00E1, 1, word, read_write, 1, kSwitch},
    RegisterRun{0x00E2, 1, word, read_write, 1, Limits{1, 11}},
    RegisterRun{0x00E3, 1, word, read_write, 0, Limits{0, 1000}},
    RegisterRun{0x00E4, 1, word, read_write, 1, kSwitch},
    RegisterRun{0x012C, 1, word, read_write, 1000, kSigned},  // P3-01
    RegisterRun{0x012D, 1, word, read_write, 5000, kSigned},
    RegisterRun{0x012E, 1, word, read_write, 10000, kSigned},
    RegisterRun{0x012F, 1, word, read_write, 15000, kSigned},
    RegisterRun{0x0130, 1, word, read_write, 10, kMilliseconds},
    RegisterRun{0x0131, 1, word, read_write, 20, kMilliseconds},
    RegisterRun{0x0132, 1, word, read_write, 30, kMilliseconds},
    RegisterRun{0x0133, 1, word, read_write, 40, kMilliseconds},
    RegisterRun{0x0134, 1, word, read_write, 10, kMilliseconds},
    RegisterRun{0x0135, 1, word, read_write, 20, kMilliseconds},
    RegisterRun{0x0136, 1, word, read_write, 30, kMilliseconds},
    RegisterRun{0x0137, 1, word, read_write, 40, kMilliseconds},
    RegisterRun{0x0138, 1, word, read_write, 0, Limits{0, 100}},
    RegisterRun{0x0139, 1, word, read_write, 0, kUnsigned},
    RegisterRun{0x013A, 1, word, read_write, 0, Limits{0, 1000}},
    RegisterRun{0x013B, 1, word, read_write, 0, kUnsigned},
    RegisterRun{0x013C, 1, word, read_write, 0, Limits{0, 2}},
    RegisterRun{0x013D, 1, word, read_write, 0, Limits{-10000, 10000}},
    RegisterRun{0x0190, 1, word, read_write, 0, Limits{0, 100}},  // P4-01
    RegisterRun{0x0191, 1, word, read_write, 1, Limits{1, 0xFFFF}},
    RegisterRun{0x0192, 1, word, read_write, 0xFFFF, kUnsigned},
    RegisterRun{0x0193, 1, word, read_write, 0, Limits{0, 5}},
    RegisterRun{0x0194, 2, word, read_write, 0, kMilliseconds},
    RegisterRun{0x0196, 1, word, read_write, 0, kMilliseconds},
    // P5-01 is 10 at first, P5-02 is 20, and so on.
    RegisterRun{kFdaFirstPosition, 32, word, read_write, 100, kSigned, 100},
    RegisterRun{kFdaOperatorCommand, 1, word, read_write}};

}  // namespace

RegisterMap fda6000_registers() { return kRegisters; }

}  // namespace mbgate::sim

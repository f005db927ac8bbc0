// SPDX-License-Identifier: Apache-2.0
// Registers of MOONS' STF drives ("Modbus User Manual",
// Appendix 5). Behind each run stand its printed register numbers and the commands that set or read
// them.
#include <array>

#include "sim/drives/maps/moons_limits.hpp"
#include "sim/drives/maps/moons_map.hpp"

namespace mbgate::sim {
namespace {

using enum Access;
using enum Width;

// 40054..55 and 40185..186 are printed as SHORTs (lines 1509, 1613) but are one value each.
// Manual lines 1461 to 1660.
constexpr std::array kStf{
    RegisterRun{0x0000, 1, word, read_only},                     // 40001 AL
    RegisterRun{0x0001, 1, word, read_only, 0x0009},             // 40002 SC
    RegisterRun{0x0002, 2, word, read_only},                     // 40003..40004 IS
    RegisterRun{0x0004, 3, value, read_only},                    // 40005..40010 IP, SP
    RegisterRun{0x000A, 2, word, read_only},                     // 40011..40012 IV1
    RegisterRun{0x000C, 1, word, read_only, 400},                // 40013 IT
    RegisterRun{0x000D, 1, word, read_only, 240},                // 40014 IU
    RegisterRun{0x000E, 1, value, read_only},                    // 40015..40016 IX
    RegisterRun{0x0010, 3, word, read_only},                     // 40017..40019 IA, IC
    RegisterRun{0x0013, 2, value, read_only},                    // 40020..40023 ID
    RegisterRun{0x0017, 4, word, read_only},                     // 40024..40027 IA1, IA2, CM
    RegisterRun{0x001B, 3, word, read_write, 240, kRate},        // 40028..40030 AC, DE, VE
    RegisterRun{0x001E, 2, value, read_write},                   // 40031..40034 DI, DC
    RegisterRun{0x0022, 1, word, read_write, 240, kRate},        // 40035 VC
    RegisterRun{0x0023, 5, word, read_only},                     // 40036..40040
    RegisterRun{0x0028, 1, value, read_write},                   // 40041..40042
    RegisterRun{0x002A, 1, word, read_write},                    // 40043
    RegisterRun{0x002B, 1, word, read_only},                     // 40044 reserved
    RegisterRun{0x002C, 1, value, read_write},                   // 40045..40046
    RegisterRun{0x002E, 3, word, read_write, 240, kRate},        // 40047..40049 JA, JL, JS
    RegisterRun{0x0031, 4, word, read_write},                    // 40050..40053 CA, CC, CI, EG
    RegisterRun{0x0035, 1, value, read_write},                   // 40054..40055
    RegisterRun{0x0037, 3, word, read_write},                    // 40056..40058 AP, AT, AV
    RegisterRun{0x003A, 23, value, read_write},                  // 40059..40104
    RegisterRun{0x0068, 3, word, read_write},                    // 40105..40107 BD, BE, CD
    RegisterRun{0x006B, 2, word, read_only},                     // 40108..40109 reserved
    RegisterRun{0x006D, 1, word, read_write},                    // 40110 AF
    RegisterRun{0x006E, 3, word, read_only},                     // 40111..40113 AL1
    RegisterRun{0x0071, 2, word, read_write},                    // 40114..40115
    RegisterRun{0x0073, 3, word, read_only},                     // 40116..40118 reserved
    RegisterRun{0x0076, 30, word, read_write},                   // 40119..40148 HG to LV
    RegisterRun{0x0094, 1, word, read_write, 5, Limits{1, 5}},   // 40149 BR
    RegisterRun{0x0095, 1, word, read_write, 5, kProtocol},      // 40150 PR
    RegisterRun{0x0096, 1, word, read_write, 0, Limits{0, 20}},  // 40151 TD
    RegisterRun{0x0097, 8, word, read_only},                     // 40152..40159 reserved
    RegisterRun{0x009F, 1, word, read_write},                    // 40160 AM
    RegisterRun{0x00A0, 1, word, read_only},                     // 40161 reserved
    RegisterRun{0x00A1, 1, word, read_write, 1, Limits{1, 32}},  // 40162 DA
    RegisterRun{0x00A2, 1, word, read_only},                     // 40163 reserved
    RegisterRun{0x00A3, 1, word, read_write},                    // 40164 JC
    RegisterRun{0x00A4, 2, word, read_only},                     // 40165..40166 reserved
    RegisterRun{0x00A6, 9, word, read_write},                    // 40167..40175 HA1 to HV3
    RegisterRun{0x00AF, 6, word, read_only},                     // 40176..40181 reserved
    RegisterRun{0x00B5, 2, word, read_write},                    // 40182..40183 MA, JT
    RegisterRun{0x00B7, 1, word, read_only},                     // 40184 reserved
    RegisterRun{0x00B8, 1, value, read_write},                   // 40185..40186 HO
    RegisterRun{0x00BA, 13, word, read_only},                    // 40187..40199 reserved
    RegisterRun{0x00C7, 39, word, read_write},                   // 40200..40238 MZA to NYD
    RegisterRun{0x00EE, 12, word, read_only}};                   // 40239..40250 reserved

}  // namespace

RegisterMap moons_stf_registers() { return kStf; }

}  // namespace mbgate::sim

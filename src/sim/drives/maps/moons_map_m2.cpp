// SPDX-License-Identifier: Apache-2.0
// Registers of MOONS' M2 drives ("Modbus User Manual",
// Appendix 5). Behind each run stand its printed register numbers and the commands that set or read
// them.
#include <array>

#include "sim/drives/maps/moons_limits.hpp"
#include "sim/drives/maps/moons_map.hpp"

namespace mbgate::sim {
namespace {

using enum Access;
using enum Width;

// Manual lines 1842 to 2027.
constexpr std::array kM2{
    RegisterRun{0x0000, 1, word, read_only},                     // 40001 AL
    RegisterRun{0x0001, 1, word, read_only, 0x0009},             // 40002 SC
    RegisterRun{0x0002, 2, word, read_only},                     // 40003..40004 IO, IS
    RegisterRun{0x0004, 2, value, read_only},                    // 40005..40008 IE, EP, IP
    RegisterRun{0x0008, 1, value, write_only},                   // 40009..40010 SP
    RegisterRun{0x000A, 2, word, read_only},                     // 40011..40012 IV0, IV1
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
    RegisterRun{0x002A, 2, word, read_write},                    // 40043..40044 GC
    RegisterRun{0x002C, 1, value, read_write},                   // 40045..40046
    RegisterRun{0x002E, 3, word, read_write, 240, kRate},        // 40047..40049 JA, JL, JS
    RegisterRun{0x0031, 3, word, read_write},                    // 40050..40052 CC, CP
    RegisterRun{0x0034, 1, word, read_only},                     // 40053 reserved
    RegisterRun{0x0035, 1, value, read_write},                   // 40054..40055
    RegisterRun{0x0037, 3, word, read_write},                    // 40056..40058 AP, AT, AV
    RegisterRun{0x003A, 1, value, read_only},                    // 40059..40060
    RegisterRun{0x003C, 22, value, read_write},                  // 40061..40104
    RegisterRun{0x0068, 2, word, read_write},                    // 40105..40106 BD, BE
    RegisterRun{0x006A, 3, word, read_only},                     // 40107..40109
    RegisterRun{0x006D, 1, word, read_write},                    // 40110 AF
    RegisterRun{0x006E, 2, word, read_only},                     // 40111..40112 AL1
    RegisterRun{0x0070, 36, word, read_write},                   // 40113..40148 JC1 to AM
    RegisterRun{0x0094, 3, word, read_only},                     // 40149..40151 ER, EG
    RegisterRun{0x0097, 2, word, read_write},                    // 40152..40153 EN, EU
    RegisterRun{0x0099, 1, word, read_only},                     // 40154 SZ
    RegisterRun{0x009A, 21, word, read_write},                   // 40155..40175 PF to MO
    RegisterRun{0x00AF, 1, word, read_only},                     // 40176 reserved
    RegisterRun{0x00B0, 1, word, read_write, 5, kProtocol},      // 40177 PR
    RegisterRun{0x00B1, 1, word, read_write, 0, Limits{0, 20}},  // 40178 TD
    RegisterRun{0x00B2, 1, word, read_write, 5, Limits{1, 5}},   // 40179 BR
    RegisterRun{0x00B3, 1, word, read_write, 1, Limits{1, 32}},  // 40180 DA
    RegisterRun{0x00B4, 18, word, read_write},                   // 40181..40198 VR to ZT
    RegisterRun{0x00C6, 2, word, read_only}};                    // 40199..40200 reserved

}  // namespace

RegisterMap moons_m2_registers() { return kM2; }

}  // namespace mbgate::sim

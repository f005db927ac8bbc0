// SPDX-License-Identifier: Apache-2.0
// Registers of MOONS' ST, STAC, STM and SWM; STB drives ("Modbus User Manual",
// Appendix 5). Behind each run stand its printed register numbers and the commands that set or read
// them.
#include <array>

#include "sim/drives/maps/moons_map.hpp"

namespace mbgate::sim {
namespace {

using enum Access;
using enum Width;

// Manual lines 1245 to 1339.
constexpr auto kSt = joined(
    kMoonsStart,
    std::array{RegisterRun{0x0004, 3, value, read_only}},  // 40005..40010 IE, EP, IP, SP
    kMoonsMotion,
    std::array{RegisterRun{0x002A, 2, word, read_write},              // 40043..40044
               RegisterRun{0x002C, 1, value, read_write},             // 40045..40046
               RegisterRun{0x002E, 3, word, read_write, 240, kRate},  // 40047..40049 JA, JL, JS
               RegisterRun{0x0031, 4, word, read_write},              // 40050..40053 CA, CC, CI
               RegisterRun{0x0035, 1, value, read_write},             // 40054..40055
               RegisterRun{0x0037, 3, word, read_write},              // 40056..40058 AP, AT, AV
               RegisterRun{0x003A, 23, value, read_write},            // 40059..40104
               RegisterRun{0x0068, 3, word, read_write},              // 40105..40107 BD, BE, CD
               RegisterRun{0x006B, 2, word, read_only},               // 40108..40109 reserved
               RegisterRun{0x006D, 1, word, read_write},              // 40110 AF
               RegisterRun{0x006E, 14, word, read_only},              // 40111..40124 reserved
               RegisterRun{0x007C, 6, word, read_write}});            // 40125..40130

// 40054..55 is printed as two SHORTs (line 1389) but is the pulse counter of the other series.
// Manual lines 1341 to 1459.
constexpr auto kStb = joined(
    kMoonsStart,
    std::array{RegisterRun{0x0004, 3, value, read_only}},  // 40005..40010 IE, EP, IP, SP
    kMoonsMotion,
    std::array{RegisterRun{0x002A, 1, word, read_write},              // 40043
               RegisterRun{0x002B, 1, word, read_only},               // 40044 reserved
               RegisterRun{0x002C, 1, value, read_write},             // 40045..40046
               RegisterRun{0x002E, 3, word, read_write, 240, kRate},  // 40047..40049 JA, JL, JS
               RegisterRun{0x0031, 4, word, read_write},              // 40050..40053 CA, CC, CI, EG
               RegisterRun{0x0035, 1, value, read_write},             // 40054..40055
               RegisterRun{0x0037, 3, word, read_write},              // 40056..40058 AP, AT, AV
               RegisterRun{0x003A, 1, value, read_only},              // 40059..40060
               RegisterRun{0x003C, 22, value, read_write},            // 40061..40104
               RegisterRun{0x0068, 3, word, read_write},              // 40105..40107 BD, BE, CD
               RegisterRun{0x006B, 2, word, read_only},               // 40108..40109 reserved
               RegisterRun{0x006D, 1, word, read_write},              // 40110 AF
               RegisterRun{0x006E, 14, word, read_only},              // 40111..40124 reserved
               RegisterRun{0x007C, 11, word, read_write},             // 40125..40135 HG, HP, SF
               RegisterRun{0x0087, 2, word, read_only},               // 40136..40137 reserved
               RegisterRun{0x0089, 8, word, read_write},              // 40138..40145 CM to MO
               RegisterRun{0x0091, 2, word, read_only},               // 40146..40147 reserved
               RegisterRun{0x0093, 1, word, read_write},              // 40148 LV
               RegisterRun{0x0094, 1, word, read_write, 5, Limits{1, 5}},   // 40149 BR
               RegisterRun{0x0095, 1, word, read_write, 5, kProtocol},      // 40150 PR
               RegisterRun{0x0096, 1, word, read_write, 0, Limits{0, 20}},  // 40151 TD
               RegisterRun{0x0097, 49, word, read_only}});                  // 40152..40200 reserved

// Manual lines 2430 to 2611.
constexpr auto kMdx = joined(
    kMoonsStart, std::array{RegisterRun{0x0004, 3, value, read_only}},  // 40005..40010 IE, EP, IP
    kMoonsMotion,
    std::array{RegisterRun{0x002A, 2, word, read_write},              // 40043..40044 GC
               RegisterRun{0x002C, 1, value, read_write},             // 40045..40046
               RegisterRun{0x002E, 3, word, read_write, 240, kRate},  // 40047..40049 JA, JL, JS
               RegisterRun{0x0031, 3, word, read_write},              // 40050..40052 VM, CC, CP
               RegisterRun{0x0034, 1, word, read_only},               // 40053 reserved
               RegisterRun{0x0035, 1, value, read_write},             // 40054..40055
               RegisterRun{0x0037, 3, word, read_write},              // 40056..40058 AP, AT, AV
               RegisterRun{0x003A, 1, value, read_only},              // 40059..40060
               RegisterRun{0x003C, 22, value, read_write},            // 40061..40104
               RegisterRun{0x0068, 2, word, read_write},              // 40105..40106 BD, BE
               RegisterRun{0x006A, 3, word, read_only},               // 40107..40109
               RegisterRun{0x006D, 1, word, read_write},              // 40110 AF
               RegisterRun{0x006E, 2, word, read_only},               // 40111..40112 AL1
               RegisterRun{0x0070, 1, word, read_write},              // 40113 JC1
               RegisterRun{0x0071, 7, word, read_only},               // 40114..40120 reserved
               RegisterRun{0x0078, 11, word, read_write},             // 40121..40131 JT
               RegisterRun{0x0083, 1, word, read_only},               // 40132 reserved
               RegisterRun{0x0084, 11, word, read_write},             // 40133..40143 KF to CM
               RegisterRun{0x008F, 1, word, read_only},               // 40144 reserved
               RegisterRun{0x0090, 4, word, read_write},              // 40145..40148 PM, JM, HC, AM
               RegisterRun{0x0094, 6, word, read_only},               // 40149..40154 ER, EG, SZ
               RegisterRun{0x009A, 17, word, read_write},             // 40155..40171 PF to DL
               RegisterRun{0x00AB, 1, word, read_only},               // 40172 reserved
               RegisterRun{0x00AC, 3, word, read_write},              // 40173..40175 AO, BO, MO
               RegisterRun{0x00AF, 1, word, read_only},               // 40176 reserved
               RegisterRun{0x00B0, 1, word, read_write, 5, kProtocol},      // 40177 PR
               RegisterRun{0x00B1, 1, word, read_write, 0, Limits{0, 20}},  // 40178 TD
               RegisterRun{0x00B2, 1, word, read_write, 5, Limits{1, 5}},   // 40179 BR
               RegisterRun{0x00B3, 1, word, read_write, 1, Limits{1, 32}},  // 40180 DA
               RegisterRun{0x00B4, 1, word, read_write},                    // 40181 VR
               RegisterRun{0x00B5, 1, word, read_only},                     // 40182 reserved
               RegisterRun{0x00B6, 2, word, read_write},                    // 40183..40184 TV, TL
               RegisterRun{0x00B8, 1, word, read_only},                     // 40185 reserved
               RegisterRun{0x00B9, 10, word, read_write},  // 40186..40195 MA to HV3
               RegisterRun{0x00C3, 1, word, read_only}});  // 40196 reserved

// Manual lines 2613 to 2707.
constexpr std::array kBldc{
    RegisterRun{0x0000, 1, word, read_only},               // 40001 AL
    RegisterRun{0x0001, 1, word, read_only, 0x0001},       // 40002 SC
    RegisterRun{0x0002, 2, word, read_only},               // 40003..40004 IS
    RegisterRun{0x0004, 2, value, read_only},              // 40005..40008 reserved
    RegisterRun{0x0008, 1, value, write_only},             // 40009..40010 reserved
    RegisterRun{0x000A, 2, word, read_only},               // 40011..40012 IV0
    RegisterRun{0x000C, 1, word, read_only, 400},          // 40013 IT
    RegisterRun{0x000D, 1, word, read_only, 240},          // 40014 IU
    RegisterRun{0x000E, 1, value, read_only},              // 40015..40016 reserved
    RegisterRun{0x0010, 3, word, read_only},               // 40017..40019 IA, IC
    RegisterRun{0x0013, 2, value, read_only},              // 40020..40023 reserved
    RegisterRun{0x0017, 4, word, read_only},               // 40024..40027 CM
    RegisterRun{0x001B, 3, word, read_write},              // 40028..40030 reserved
    RegisterRun{0x001E, 2, value, read_write},             // 40031..40034 reserved
    RegisterRun{0x0022, 1, word, read_write},              // 40035 reserved
    RegisterRun{0x0023, 5, word, read_only},               // 40036..40040
    RegisterRun{0x0028, 1, value, read_write},             // 40041..40042 reserved
    RegisterRun{0x002A, 2, word, read_write},              // 40043..40044 reserved
    RegisterRun{0x002C, 1, value, read_write},             // 40045..40046 reserved
    RegisterRun{0x002E, 3, word, read_write, 240, kRate},  // 40047..40049 JA, JL, JS
    RegisterRun{0x0031, 9, word, read_write},              // 40050..40058 CC, AV
    RegisterRun{0x003A, 23, value, read_write},            // 40059..40104
    RegisterRun{0x0068, 26, word, read_write}};            // 40105..40130

}  // namespace

RegisterMap moons_st_registers() { return kSt; }
RegisterMap moons_stb_registers() { return kStb; }
RegisterMap moons_mdx_registers() { return kMdx; }
RegisterMap moons_bldc_registers() { return kBldc; }

}  // namespace mbgate::sim

// SPDX-License-Identifier: Apache-2.0
// Registers of MOONS' SSDC, SS, RS, SSM, TSM and TXM drives ("Modbus User Manual",
// Appendix 5). Behind each run stand its printed register numbers and the commands that set or read
// them.
#include <array>

#include "sim/drives/maps/moons_limits.hpp"
#include "sim/drives/maps/moons_map.hpp"

namespace mbgate::sim {
namespace {

using enum Access;
using enum Width;

// Manual lines 1664 to 1840.
constexpr std::array kSsdc{
    RegisterRun{0x0000, 1, word, read_only},                     // 40001 AL
    RegisterRun{0x0001, 1, word, read_only, 0x0009},             // 40002 SC
    RegisterRun{0x0002, 2, word, read_only},                     // 40003..40004 IS
    RegisterRun{0x0004, 3, value, read_only},                    // 40005..40010 IE, EP, IP, SP
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
    RegisterRun{0x0031, 4, word, read_write},                    // 40050..40053 VM, CC, CP, EG
    RegisterRun{0x0035, 1, value, read_write},                   // 40054..40055
    RegisterRun{0x0037, 3, word, read_write},                    // 40056..40058 AP, AT, AV
    RegisterRun{0x003A, 1, value, read_only},                    // 40059..40060
    RegisterRun{0x003C, 22, value, read_write},                  // 40061..40104
    RegisterRun{0x0068, 3, word, read_write},                    // 40105..40107 BD, BE, CD
    RegisterRun{0x006B, 2, word, read_only},                     // 40108..40109 CA
    RegisterRun{0x006D, 1, word, read_write},                    // 40110 AF
    RegisterRun{0x006E, 8, word, read_only},                     // 40111..40118 AL1
    RegisterRun{0x0076, 12, word, read_write},                   // 40119..40130 FI3, FI4
    RegisterRun{0x0082, 2, word, read_only},                     // 40131..40132 reserved
    RegisterRun{0x0084, 4, word, read_write},                    // 40133..40136 SF, AU, SZ
    RegisterRun{0x0088, 1, word, read_only},                     // 40137 reserved
    RegisterRun{0x0089, 8, word, read_write},                    // 40138..40145 CM to MO
    RegisterRun{0x0091, 2, word, read_only},                     // 40146..40147 reserved
    RegisterRun{0x0093, 1, word, read_write},                    // 40148 LV
    RegisterRun{0x0094, 1, word, read_write, 5, Limits{1, 5}},   // 40149 BR
    RegisterRun{0x0095, 1, word, read_write, 5, kProtocol},      // 40150 PR
    RegisterRun{0x0096, 1, word, read_write, 0, Limits{0, 20}},  // 40151 TD
    RegisterRun{0x0097, 1, word, read_only},                     // 40152 reserved
    RegisterRun{0x0098, 9, word, read_write},                    // 40153..40161 KP to PF
    RegisterRun{0x00A1, 1, word, read_write, 1, Limits{1, 32}},  // 40162 DA
    RegisterRun{0x00A2, 20, word, read_write},                   // 40163..40182 AG to MA
    RegisterRun{0x00B6, 5, word, read_only},                     // 40183..40187 reserved
    RegisterRun{0x00BB, 1, value, read_write},                   // 40188..40189 HO
    RegisterRun{0x00BD, 1, value, read_only},                    // 40190..40191 EQ
    RegisterRun{0x00BF, 4, word, read_only},                     // 40192..40195 reserved
    RegisterRun{0x00C3, 3, word, read_write},                    // 40196..40198 ZE, ZS, ZA
    RegisterRun{0x00C6, 2, word, read_only}};                    // 40199..40200 MV, MV1

}  // namespace

RegisterMap moons_ssdc_registers() { return kSsdc; }

}  // namespace mbgate::sim

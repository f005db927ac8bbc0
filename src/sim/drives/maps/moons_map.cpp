// SPDX-License-Identifier: Apache-2.0
#include "sim/drives/maps/moons_map.hpp"

namespace mbgate::sim {
namespace {

constexpr MoonsPlaces kWithoutProtocol{};
constexpr MoonsPlaces kStep{.protocol = 0x0095};   // 40150
constexpr MoonsPlaces kServo{.protocol = 0x00B0};  // 40177
constexpr MoonsPlaces kM3Places{.status = 0x0002,
                                .encoder_position = 0x000A,
                                .position = 0x0006,
                                .position_command = std::nullopt,
                                .velocity = 0x0010,
                                .target_velocity = 0x0011,
                                .relative_distance = 0x0020,
                                .distance = 0x015E,
                                .jog_velocity = 0x0156,
                                .protocol = 0x0120};  // 40289..40290
// Enabled, alarm, jogging, decelerating.
constexpr MoonsPlaces kBldcPlaces{.status_bits = 0x0265};

using enum Access;
using enum Width;

// Manual lines 1842 to 2027.
constexpr auto kM2 = joined(
    kMoonsStart,
    std::array{RegisterRun{0x0004, 2, value, read_only},    // 40005..40008 IE, EP, IP
               RegisterRun{0x0008, 1, value, write_only}},  // 40009..40010 SP
    kMoonsMotion,
    std::array{RegisterRun{0x002A, 2, word, read_write},                // 40043..40044 GC
               RegisterRun{0x002C, 1, value, read_write},               // 40045..40046
               RegisterRun{0x002E, 3, word, read_write, 240, kRate},    // 40047..40049 JA, JL, JS
               RegisterRun{0x0031, 3, word, read_write},                // 40050..40052 CC, CP
               RegisterRun{0x0034, 1, word, read_only},                 // 40053 reserved
               RegisterRun{0x0035, 1, value, read_write},               // 40054..40055
               RegisterRun{0x0037, 3, word, read_write},                // 40056..40058 AP, AT, AV
               RegisterRun{0x003A, 1, value, read_only},                // 40059..40060
               RegisterRun{0x003C, 22, value, read_write},              // 40061..40104
               RegisterRun{0x0068, 2, word, read_write},                // 40105..40106 BD, BE
               RegisterRun{0x006A, 3, word, read_only},                 // 40107..40109
               RegisterRun{0x006D, 1, word, read_write},                // 40110 AF
               RegisterRun{0x006E, 2, word, read_only},                 // 40111..40112 AL1
               RegisterRun{0x0070, 36, word, read_write},               // 40113..40148 JC1 to AM
               RegisterRun{0x0094, 3, word, read_only},                 // 40149..40151 ER, EG
               RegisterRun{0x0097, 2, word, read_write},                // 40152..40153 EN, EU
               RegisterRun{0x0099, 1, word, read_only},                 // 40154 SZ
               RegisterRun{0x009A, 21, word, read_write},               // 40155..40175 PF to MO
               RegisterRun{0x00AF, 1, word, read_only},                 // 40176 reserved
               RegisterRun{0x00B0, 1, word, read_write, 5, kProtocol},  // 40177 PR
               RegisterRun{0x00B1, 1, word, read_write, 0, Limits{0, 20}},  // 40178 TD
               RegisterRun{0x00B2, 1, word, read_write, 5, Limits{1, 5}},   // 40179 BR
               RegisterRun{0x00B3, 1, word, read_write, 1, Limits{1, 32}},  // 40180 DA
               RegisterRun{0x00B4, 18, word, read_write},                   // 40181..40198 VR to ZT
               RegisterRun{0x00C6, 2, word, read_only}});                   // 40199..40200 reserved

// Manual lines 1664 to 1840.
constexpr auto kSsdc = joined(
    kMoonsStart,
    std::array{RegisterRun{0x0004, 3, value, read_only}},  // 40005..40010 IE, EP, IP, SP
    kMoonsMotion,
    std::array{RegisterRun{0x002A, 2, word, read_write},              // 40043..40044 GC
               RegisterRun{0x002C, 1, value, read_write},             // 40045..40046
               RegisterRun{0x002E, 3, word, read_write, 240, kRate},  // 40047..40049 JA, JL, JS
               RegisterRun{0x0031, 4, word, read_write},              // 40050..40053 VM, CC, CP, EG
               RegisterRun{0x0035, 1, value, read_write},             // 40054..40055
               RegisterRun{0x0037, 3, word, read_write},              // 40056..40058 AP, AT, AV
               RegisterRun{0x003A, 1, value, read_only},              // 40059..40060
               RegisterRun{0x003C, 22, value, read_write},            // 40061..40104
               RegisterRun{0x0068, 3, word, read_write},              // 40105..40107 BD, BE, CD
               RegisterRun{0x006B, 2, word, read_only},               // 40108..40109 CA
               RegisterRun{0x006D, 1, word, read_write},              // 40110 AF
               RegisterRun{0x006E, 8, word, read_only},               // 40111..40118 AL1
               RegisterRun{0x0076, 12, word, read_write},             // 40119..40130 FI3, FI4
               RegisterRun{0x0082, 2, word, read_only},               // 40131..40132 reserved
               RegisterRun{0x0084, 4, word, read_write},              // 40133..40136 SF, AU, SZ
               RegisterRun{0x0088, 1, word, read_only},               // 40137 reserved
               RegisterRun{0x0089, 8, word, read_write},              // 40138..40145 CM to MO
               RegisterRun{0x0091, 2, word, read_only},               // 40146..40147 reserved
               RegisterRun{0x0093, 1, word, read_write},              // 40148 LV
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
               RegisterRun{0x00C3, 3, word, read_write},   // 40196..40198 ZE, ZS, ZA
               RegisterRun{0x00C6, 2, word, read_only}});  // 40199..40200 MV, MV1

// 40054..55 and 40185..186 are printed as SHORTs (lines 1509, 1613) but are one value each.
// Manual lines 1461 to 1660.
constexpr auto kStf = joined(
    kMoonsStart, std::array{RegisterRun{0x0004, 3, value, read_only}},  // 40005..40010 IP, SP
    kMoonsMotion,
    std::array{RegisterRun{0x002A, 1, word, read_write},              // 40043
               RegisterRun{0x002B, 1, word, read_only},               // 40044 reserved
               RegisterRun{0x002C, 1, value, read_write},             // 40045..40046
               RegisterRun{0x002E, 3, word, read_write, 240, kRate},  // 40047..40049 JA, JL, JS
               RegisterRun{0x0031, 4, word, read_write},              // 40050..40053 CA, CC, CI, EG
               RegisterRun{0x0035, 1, value, read_write},             // 40054..40055
               RegisterRun{0x0037, 3, word, read_write},              // 40056..40058 AP, AT, AV
               RegisterRun{0x003A, 23, value, read_write},            // 40059..40104
               RegisterRun{0x0068, 3, word, read_write},              // 40105..40107 BD, BE, CD
               RegisterRun{0x006B, 2, word, read_only},               // 40108..40109 reserved
               RegisterRun{0x006D, 1, word, read_write},              // 40110 AF
               RegisterRun{0x006E, 3, word, read_only},               // 40111..40113 AL1
               RegisterRun{0x0071, 2, word, read_write},              // 40114..40115
               RegisterRun{0x0073, 3, word, read_only},               // 40116..40118 reserved
               RegisterRun{0x0076, 30, word, read_write},             // 40119..40148 HG to LV
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
               RegisterRun{0x00A6, 9, word, read_write},    // 40167..40175 HA1 to HV3
               RegisterRun{0x00AF, 6, word, read_only},     // 40176..40181 reserved
               RegisterRun{0x00B5, 2, word, read_write},    // 40182..40183 MA, JT
               RegisterRun{0x00B7, 1, word, read_only},     // 40184 reserved
               RegisterRun{0x00B8, 1, value, read_write},   // 40185..40186 HO
               RegisterRun{0x00BA, 13, word, read_only},    // 40187..40199 reserved
               RegisterRun{0x00C7, 39, word, read_write},   // 40200..40238 MZA to NYD
               RegisterRun{0x00EE, 12, word, read_only}});  // 40239..40250 reserved

}  // namespace

RegisterMap moons_registers(MoonsSeries series) {
  switch (series) {
    case MoonsSeries::st: return moons_st_registers();
    case MoonsSeries::stb: return moons_stb_registers();
    case MoonsSeries::stf: return moons_stf_registers();
    case MoonsSeries::ssdc: return moons_ssdc_registers();
    case MoonsSeries::m2: return moons_m2_registers();
    case MoonsSeries::m3: return moons_m3_registers();
    case MoonsSeries::mdx: return moons_mdx_registers();
    case MoonsSeries::bldc: return moons_bldc_registers();
  }
  return {};
}

const MoonsPlaces& moons_places(MoonsSeries series) {
  switch (series) {
    case MoonsSeries::st: return kWithoutProtocol;
    case MoonsSeries::stb:
    case MoonsSeries::stf:
    case MoonsSeries::ssdc: return kStep;
    case MoonsSeries::m2:
    case MoonsSeries::mdx: return kServo;
    case MoonsSeries::m3: return kM3Places;
    case MoonsSeries::bldc: return kBldcPlaces;
  }
  return kWithoutProtocol;
}

RegisterMap moons_m2_registers() { return kM2; }
RegisterMap moons_ssdc_registers() { return kSsdc; }
RegisterMap moons_stf_registers() { return kStf; }

}  // namespace mbgate::sim

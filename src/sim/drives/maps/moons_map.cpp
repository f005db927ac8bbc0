// SPDX-License-Identifier: Apache-2.0
// Behind each run stand its printed register numbers and the commands that set or read them, as far
// as the series have the same.
#include "sim/drives/maps/moons_map.hpp"

#include <array>
#include <cstddef>
#include <vector>

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

// Ranges of registers. The manual prints none in its tables; what counts here is that a rate of 0
// is none.
constexpr Limits kRate{1, 32000};
constexpr Limits kProtocol{1, 511};

/// A bit for each series of the table.
enum SeriesBit : unsigned {
  st = 1U << static_cast<unsigned>(MoonsSeries::st),
  stb = 1U << static_cast<unsigned>(MoonsSeries::stb),
  stf = 1U << static_cast<unsigned>(MoonsSeries::stf),
  ssdc = 1U << static_cast<unsigned>(MoonsSeries::ssdc),
  m2 = 1U << static_cast<unsigned>(MoonsSeries::m2),
  mdx = 1U << static_cast<unsigned>(MoonsSeries::mdx)
};
constexpr unsigned kAll = st | stb | stf | ssdc | m2 | mdx;

struct MoonsRun {
  RegisterRun run;
  unsigned series;  ///< the bits of those that have it
};

// All series but M3 and BLDC. Manual lines 1245 to 1339 (ST), 1341 to 1459 (STB), 1461 to 1660
// (STF), 1664 to 1840 (SSDC), 1842 to 2027 (M2), 2430 to 2611 (MDX). 40054..55 and 40185..186 are
// printed as SHORTs in STB's and STF's (lines 1389, 1509, 1613) but are one value each.
constexpr std::array kRuns{
    MoonsRun{{0x0000, 1, word, read_only}, kAll},          // 40001 AL
    MoonsRun{{0x0001, 1, word, read_only, 0x0009}, kAll},  // 40002 SC
    MoonsRun{{0x0002, 2, word, read_only}, kAll},          // 40003..40004 IS, ISX
    MoonsRun{{0x0004, 2, value, read_only}, m2},           // 40005..40008 IE, EP, IP
    MoonsRun{{0x0004, 3, value, read_only},
             ssdc | stf | st | stb | mdx},                          // 40005..40010 IE, EP, IP, SP
    MoonsRun{{0x0008, 1, value, write_only}, m2},                   // 40009..40010 SP
    MoonsRun{{0x000A, 2, word, read_only}, kAll},                   // 40011..40012 IV0, IV1
    MoonsRun{{0x000C, 1, word, read_only, 400}, kAll},              // 40013 IT
    MoonsRun{{0x000D, 1, word, read_only, 240}, kAll},              // 40014 IU
    MoonsRun{{0x000E, 1, value, read_only}, kAll},                  // 40015..40016 IX
    MoonsRun{{0x0010, 3, word, read_only}, kAll},                   // 40017..40019 IA, IC
    MoonsRun{{0x0013, 2, value, read_only}, kAll},                  // 40020..40023 ID
    MoonsRun{{0x0017, 4, word, read_only}, kAll},                   // 40024..40027 IA1, IA2, CM
    MoonsRun{{0x001B, 3, word, read_write, 240, kRate}, kAll},      // 40028..40030 AC, DE, VE
    MoonsRun{{0x001E, 2, value, read_write}, kAll},                 // 40031..40034 DI, DC
    MoonsRun{{0x0022, 1, word, read_write, 240, kRate}, kAll},      // 40035 VC
    MoonsRun{{0x0023, 5, word, read_only}, kAll},                   // 40036..40040
    MoonsRun{{0x0028, 1, value, read_write}, kAll},                 // 40041..40042
    MoonsRun{{0x002A, 2, word, read_write}, m2 | ssdc | st | mdx},  // 40043..40044 GC
    MoonsRun{{0x002A, 1, word, read_write}, stf | stb},             // 40043
    MoonsRun{{0x002B, 1, word, read_only}, stf | stb},              // 40044 reserved
    MoonsRun{{0x002C, 1, value, read_write}, kAll},                 // 40045..40046
    MoonsRun{{0x002E, 3, word, read_write, 240, kRate}, kAll},      // 40047..40049 JA, JL, JS
    MoonsRun{{0x0031, 3, word, read_write}, m2 | mdx},              // 40050..40052 CC, CP, VM
    MoonsRun{{0x0031, 4, word, read_write},
             ssdc | stf | st | stb},                   // 40050..40053 VM, CC, CP, EG, CA, CI
    MoonsRun{{0x0034, 1, word, read_only}, m2 | mdx},  // 40053 reserved
    MoonsRun{{0x0035, 1, value, read_write}, kAll},    // 40054..40055
    MoonsRun{{0x0037, 3, word, read_write}, kAll},     // 40056..40058 AP, AT, AV
    MoonsRun{{0x003A, 1, value, read_only}, m2 | ssdc | stb | mdx},    // 40059..40060
    MoonsRun{{0x003A, 23, value, read_write}, stf | st},               // 40059..40104
    MoonsRun{{0x003C, 22, value, read_write}, m2 | ssdc | stb | mdx},  // 40061..40104
    MoonsRun{{0x0068, 2, word, read_write}, m2 | mdx},                 // 40105..40106 BD, BE
    MoonsRun{{0x0068, 3, word, read_write}, ssdc | stf | st | stb},    // 40105..40107 BD, BE, CD
    MoonsRun{{0x006A, 3, word, read_only}, m2 | mdx},                  // 40107..40109
    MoonsRun{{0x006B, 2, word, read_only}, ssdc | stf | st | stb},     // 40108..40109 CA, reserved
    MoonsRun{{0x006D, 1, word, read_write}, kAll},                     // 40110 AF
    MoonsRun{{0x006E, 2, word, read_only}, m2 | mdx},                  // 40111..40112 AL1
    MoonsRun{{0x006E, 8, word, read_only}, ssdc},                      // 40111..40118 AL1
    MoonsRun{{0x006E, 3, word, read_only}, stf},                       // 40111..40113 AL1
    MoonsRun{{0x006E, 14, word, read_only}, st | stb},                 // 40111..40124 reserved
    MoonsRun{{0x0070, 36, word, read_write}, m2},                      // 40113..40148 JC1 to AM
    MoonsRun{{0x0070, 1, word, read_write}, mdx},                      // 40113 JC1
    MoonsRun{{0x0071, 2, word, read_write}, stf},                      // 40114..40115
    MoonsRun{{0x0071, 7, word, read_only}, mdx},                       // 40114..40120 reserved
    MoonsRun{{0x0073, 3, word, read_only}, stf},                       // 40116..40118 reserved
    MoonsRun{{0x0076, 12, word, read_write}, ssdc},                    // 40119..40130 FI3, FI4
    MoonsRun{{0x0076, 30, word, read_write}, stf},                     // 40119..40148 HG to LV
    MoonsRun{{0x0078, 11, word, read_write}, mdx},                     // 40121..40131 JT
    MoonsRun{{0x007C, 6, word, read_write}, st},                       // 40125..40130
    MoonsRun{{0x007C, 11, word, read_write}, stb},                     // 40125..40135 HG, HP, SF
    MoonsRun{{0x0082, 2, word, read_only}, ssdc},                      // 40131..40132 reserved
    MoonsRun{{0x0083, 1, word, read_only}, mdx},                       // 40132 reserved
    MoonsRun{{0x0084, 4, word, read_write}, ssdc},                     // 40133..40136 SF, AU, SZ
    MoonsRun{{0x0084, 11, word, read_write}, mdx},                     // 40133..40143 KF to CM
    MoonsRun{{0x0087, 2, word, read_only}, stb},                       // 40136..40137 reserved
    MoonsRun{{0x0088, 1, word, read_only}, ssdc},                      // 40137 reserved
    MoonsRun{{0x0089, 8, word, read_write}, ssdc | stb},               // 40138..40145 CM to MO
    MoonsRun{{0x008F, 1, word, read_only}, mdx},                       // 40144 reserved
    MoonsRun{{0x0090, 4, word, read_write}, mdx},         // 40145..40148 PM, JM, HC, AM
    MoonsRun{{0x0091, 2, word, read_only}, ssdc | stb},   // 40146..40147 reserved
    MoonsRun{{0x0093, 1, word, read_write}, ssdc | stb},  // 40148 LV
    MoonsRun{{0x0094, 3, word, read_only}, m2},           // 40149..40151 ER, EG
    MoonsRun{{0x0094, 1, word, read_write, 5, Limits{1, 5}}, ssdc | stf | stb},  // 40149 BR
    MoonsRun{{0x0094, 6, word, read_only}, mdx},  // 40149..40154 ER, EG, SZ
    MoonsRun{{0x0095, 1, word, read_write, 5, kProtocol}, ssdc | stf | stb},      // 40150 PR
    MoonsRun{{0x0096, 1, word, read_write, 0, Limits{0, 20}}, ssdc | stf | stb},  // 40151 TD
    MoonsRun{{0x0097, 2, word, read_write}, m2},                            // 40152..40153 EN, EU
    MoonsRun{{0x0097, 1, word, read_only}, ssdc},                           // 40152 reserved
    MoonsRun{{0x0097, 8, word, read_only}, stf},                            // 40152..40159 reserved
    MoonsRun{{0x0097, 49, word, read_only}, stb},                           // 40152..40200 reserved
    MoonsRun{{0x0098, 9, word, read_write}, ssdc},                          // 40153..40161 KP to PF
    MoonsRun{{0x0099, 1, word, read_only}, m2},                             // 40154 SZ
    MoonsRun{{0x009A, 21, word, read_write}, m2},                           // 40155..40175 PF to MO
    MoonsRun{{0x009A, 17, word, read_write}, mdx},                          // 40155..40171 PF to DL
    MoonsRun{{0x009F, 1, word, read_write}, stf},                           // 40160 AM
    MoonsRun{{0x00A0, 1, word, read_only}, stf},                            // 40161 reserved
    MoonsRun{{0x00A1, 1, word, read_write, 1, Limits{1, 32}}, ssdc | stf},  // 40162 DA
    MoonsRun{{0x00A2, 20, word, read_write}, ssdc},                         // 40163..40182 AG to MA
    MoonsRun{{0x00A2, 1, word, read_only}, stf},                            // 40163 reserved
    MoonsRun{{0x00A3, 1, word, read_write}, stf},                           // 40164 JC
    MoonsRun{{0x00A4, 2, word, read_only}, stf},                            // 40165..40166 reserved
    MoonsRun{{0x00A6, 9, word, read_write}, stf},                         // 40167..40175 HA1 to HV3
    MoonsRun{{0x00AB, 1, word, read_only}, mdx},                          // 40172 reserved
    MoonsRun{{0x00AC, 3, word, read_write}, mdx},                         // 40173..40175 AO, BO, MO
    MoonsRun{{0x00AF, 1, word, read_only}, m2 | mdx},                     // 40176 reserved
    MoonsRun{{0x00AF, 6, word, read_only}, stf},                          // 40176..40181 reserved
    MoonsRun{{0x00B0, 1, word, read_write, 5, kProtocol}, m2 | mdx},      // 40177 PR
    MoonsRun{{0x00B1, 1, word, read_write, 0, Limits{0, 20}}, m2 | mdx},  // 40178 TD
    MoonsRun{{0x00B2, 1, word, read_write, 5, Limits{1, 5}}, m2 | mdx},   // 40179 BR
    MoonsRun{{0x00B3, 1, word, read_write, 1, Limits{1, 32}}, m2 | mdx},  // 40180 DA
    MoonsRun{{0x00B4, 18, word, read_write}, m2},                         // 40181..40198 VR to ZT
    MoonsRun{{0x00B4, 1, word, read_write}, mdx},                         // 40181 VR
    MoonsRun{{0x00B5, 2, word, read_write}, stf},                         // 40182..40183 MA, JT
    MoonsRun{{0x00B5, 1, word, read_only}, mdx},                          // 40182 reserved
    MoonsRun{{0x00B6, 5, word, read_only}, ssdc},                         // 40183..40187 reserved
    MoonsRun{{0x00B6, 2, word, read_write}, mdx},                         // 40183..40184 TV, TL
    MoonsRun{{0x00B7, 1, word, read_only}, stf},                          // 40184 reserved
    MoonsRun{{0x00B8, 1, value, read_write}, stf},                        // 40185..40186 HO
    MoonsRun{{0x00B8, 1, word, read_only}, mdx},                          // 40185 reserved
    MoonsRun{{0x00B9, 10, word, read_write}, mdx},                        // 40186..40195 MA to HV3
    MoonsRun{{0x00BA, 13, word, read_only}, stf},                         // 40187..40199 reserved
    MoonsRun{{0x00BB, 1, value, read_write}, ssdc},                       // 40188..40189 HO
    MoonsRun{{0x00BD, 1, value, read_only}, ssdc},                        // 40190..40191 EQ
    MoonsRun{{0x00BF, 4, word, read_only}, ssdc},                         // 40192..40195 reserved
    MoonsRun{{0x00C3, 3, word, read_write}, ssdc},                        // 40196..40198 ZE, ZS, ZA
    MoonsRun{{0x00C3, 1, word, read_only}, mdx},                          // 40196 reserved
    MoonsRun{{0x00C6, 2, word, read_only}, m2 | ssdc},  // 40199..40200 reserved, MV, MV1
    MoonsRun{{0x00C7, 39, word, read_write}, stf},      // 40200..40238 MZA to NYD
    MoonsRun{{0x00EE, 12, word, read_only}, stf},       // 40239..40250 reserved
};

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

RegisterMap moons_registers(MoonsSeries series) {
  if (series == MoonsSeries::m3) {
    return moons_m3_registers();
  }
  if (series == MoonsSeries::bldc) {
    return kBldc;
  }
  static const auto kTables = [] {
    std::array<std::vector<RegisterRun>, 8> made;
    for (const MoonsRun& entry : kRuns) {
      for (std::size_t at = 0; at < made.size(); ++at) {
        if ((entry.series >> at & 1U) != 0) {
          made[at].push_back(entry.run);
        }
      }
    }
    return made;
  }();
  return kTables[static_cast<std::size_t>(series)];
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

}  // namespace mbgate::sim

// SPDX-License-Identifier: Apache-2.0
// Registers of MOONS' M3 drives ("Modbus User Manual",
// Appendix 5). Behind each run stand its printed register numbers and the commands that set or read
// them.
#include <array>

#include "sim/drives/maps/moons_map.hpp"

namespace mbgate::sim {
namespace {

using enum Access;
using enum Width;

// Here the manual prints ranges. Which modes there are between 1 and 21 (line 2213) is not checked.
// Manual lines 2029 to 2428.
constexpr std::array kM3{
    RegisterRun{0x0000, 1, value, read_only},                             // 40001..40002 AL
    RegisterRun{0x0002, 1, value, read_only, 0x0009},                     // 40003..40004 SC
    RegisterRun{0x0004, 2, word, read_only},                              // 40005..40006 IO, IS
    RegisterRun{0x0006, 4, value, read_only},                             // 40007..40014 IP, EQ, EP
    RegisterRun{0x000E, 1, word, read_write},                             // 40015 reserved
    RegisterRun{0x000F, 3, word, read_only},                              // 40016..40018 IV, IV1
    RegisterRun{0x0012, 1, word, read_only, 400},                         // 40019 IT
    RegisterRun{0x0013, 2, word, read_only},                              // 40020..40021 IT1, IT2
    RegisterRun{0x0015, 1, word, read_only, 3100},                        // 40022 IU
    RegisterRun{0x0016, 1, value, read_only},                             // 40023..40024 IX
    RegisterRun{0x0018, 1, word, read_write},                             // 40025 reserved
    RegisterRun{0x0019, 2, word, read_only},                              // 40026..40027 IA1, IA2
    RegisterRun{0x001B, 2, word, read_write},                             // 40028..40029 OA1, OA2
    RegisterRun{0x001D, 3, word, read_only},                              // 40030..40032 IC, IQ
    RegisterRun{0x0020, 2, value, read_only},                             // 40033..40036 ID
    RegisterRun{0x0024, 10, word, read_only},                             // 40037..40046
    RegisterRun{0x002E, 2, value, read_write},                            // 40047..40050
    RegisterRun{0x0032, 1, word, read_write},                             // 40051 reserved
    RegisterRun{0x0033, 2, value, read_only},                             // 40052..40055
    RegisterRun{0x0037, 1, word, read_only},                              // 40056
    RegisterRun{0x0038, 1, word, read_write},                             // 40057 reserved
    RegisterRun{0x0039, 2, word, read_only},                              // 40058..40059 reserved
    RegisterRun{0x003B, 5, word, read_write},                             // 40060..40064 reserved
    RegisterRun{0x0040, 2, word, read_write, 0, Limits{0, 3000}},         // 40065..40066
    RegisterRun{0x0042, 1, value, read_only},                             // 40067..40068
    RegisterRun{0x0044, 8, word, read_only},                              // 40069..40076
    RegisterRun{0x004C, 24, value, read_only},                            // 40077..40124
    RegisterRun{0x007C, 6, word, read_write},                             // 40125..40130
    RegisterRun{0x0082, 1, value, read_only},                             // 40131..40132
    RegisterRun{0x0084, 22, value, read_write},                           // 40133..40176
    RegisterRun{0x00B0, 1, value, read_write, 0, Limits{0, 2}},           // 40177..40178 UM
    RegisterRun{0x00B2, 1, value, read_write, 0, Limits{0, 10}},          // 40179..40180 LY
    RegisterRun{0x00B4, 1, value, read_write, 0, Limits{0, 100}},         // 40181..40182 NR
    RegisterRun{0x00B6, 2, value, read_write, 1, Limits{1, 20}},          // 40183..40186 KG, KX
    RegisterRun{0x00BA, 1, value, read_write, 0, Limits{0, 20000}},       // 40187..40188 KP
    RegisterRun{0x00BC, 2, value, read_write, 0, Limits{0, 30000}},       // 40189..40192 KI, KD
    RegisterRun{0x00C0, 1, value, read_write, 0, Limits{0, 40000}},       // 40193..40194 KE
    RegisterRun{0x00C2, 1, value, read_write, 0, Limits{-30000, 30000}},  // 40195..40196 KL
    RegisterRun{0x00C4, 1, value, read_write, 0, Limits{0, 40000}},       // 40197..40198 KR
    RegisterRun{0x00C6, 1, value, read_write, 0, Limits{-30000, 30000}},  // 40199..40200 KF
    RegisterRun{0x00C8, 2, value, read_write, 0, Limits{0, 30000}},       // 40201..40204 VP, VI
    RegisterRun{0x00CC, 1, value, read_write, 0, Limits{0, 20000}},       // 40205..40206 KK
    RegisterRun{0x00CE, 2, value, read_write, 0, Limits{0, 40000}},       // 40207..40210 KT, KC
    RegisterRun{0x00D2, 1, value, read_write, 0, Limits{0, 20000}},       // 40211..40212 UP
    RegisterRun{0x00D4, 2, value, read_write, 0, Limits{0, 30000}},       // 40213..40216 UI, UD
    RegisterRun{0x00D8, 1, value, read_write, 0, Limits{0, 40000}},       // 40217..40218 UE
    RegisterRun{0x00DA, 1, value, read_write, 0, Limits{-30000, 30000}},  // 40219..40220 UF
    RegisterRun{0x00DC, 2, value, read_write, 0, Limits{0, 30000}},       // 40221..40224 UV, UG
    RegisterRun{0x00E0, 1, value, read_write, 0, Limits{0, 40000}},       // 40225..40226 UC
    RegisterRun{0x00E2, 1, value, read_write, 0, Limits{0, 20000}},       // 40227..40228 XP
    RegisterRun{0x00E4, 1, value, read_write, 0, Limits{0, 30000}},       // 40229..40230 XI
    RegisterRun{0x00E6, 1, value, read_write, 0, Limits{0, 32767}},       // 40231..40232 XD
    RegisterRun{0x00E8, 1, value, read_write, 0, Limits{0, 40000}},       // 40233..40234 XE
    RegisterRun{0x00EA, 1, value, read_write, 0, Limits{-30000, 30000}},  // 40235..40236 XF
    RegisterRun{0x00EC, 2, value, read_write, 0, Limits{0, 30000}},       // 40237..40240 XV, XG
    RegisterRun{0x00F0, 1, value, read_write, 0, Limits{0, 40000}},       // 40241..40242 XC
    RegisterRun{0x00F2, 1, value, read_write, 0, Limits{0, 4}},           // 40243..40244 SD
    RegisterRun{0x00F4, 1, value, read_write, 0, Limits{0, 2147483647}},  // 40245..40246 PN
    RegisterRun{0x00F6, 1, value, read_write, 0, Limits{0, 24000}},       // 40247..40248 VN
    RegisterRun{0x00F8, 1, value, read_write, 0, Limits{0, 3000}},        // 40249..40250 TN
    RegisterRun{0x00FA, 2, value, read_write, 0, Limits{0, 10000}},       // 40251..40254 SE1, SE2
    RegisterRun{0x00FE, 1, value, read_write, 0, Limits{0, 3}},           // 40255..40256 LR
    RegisterRun{0x0100, 1, value, read_write, 0, Limits{0, 1}},           // 40257..40258 AE
    RegisterRun{0x0102, 2, value, read_write},                            // 40259..40262 reserved
    RegisterRun{0x0106, 2, value, read_write, 1, Limits{1, 21}},          // 40263..40266 CM, CN
    RegisterRun{0x010A, 1, value, read_write, 8, Limits{8, 10}},          // 40267..40268 PM
    RegisterRun{0x010C, 1, value, read_write, 1, Limits{1, 2}},           // 40269..40270 JM
    RegisterRun{0x010E, 1, value, read_write, 0, Limits{0, 1}},           // 40271..40272 XM
    RegisterRun{0x0110, 1, value, read_write, 0, Limits{-3000, 3000}},    // 40273..40274 GC
    RegisterRun{0x0112, 3, value, read_write, 0, Limits{0, 3000}},        // 40275..40280 CC, CV, HC
    RegisterRun{0x0118, 1, value, read_write, 0, Limits{0, 30000}},       // 40281..40282 CL
    RegisterRun{0x011A, 1, value, read_write, 0, Limits{0, 5}},           // 40283..40284 LD
    RegisterRun{0x011C, 1, value, read_write, 0, Limits{0, 1}},           // 40285..40286 RN
    RegisterRun{0x011E, 1, value, read_write},                            // 40287..40288 reserved
    RegisterRun{0x0120, 1, value, read_write, 5, Limits{1, 511}},         // 40289..40290 PR
    RegisterRun{0x0122, 1, value, read_write, 0, Limits{0, 20}},          // 40291..40292 TD
    RegisterRun{0x0124, 1, value, read_write, 5, Limits{1, 5}},           // 40293..40294 BR
    RegisterRun{0x0126, 1, value, read_write, 1, Limits{0, 32}},          // 40295..40296 DA
    RegisterRun{0x0128, 1, value, read_write, 1, Limits{1, 127}},         // 40297..40298 CO
    RegisterRun{0x012A, 1, value, read_write, 0, Limits{0, 7}},           // 40299..40300
    RegisterRun{0x012C, 1, value, read_write, 10, Limits{10, 32000}},     // 40301..40302 ZR
    RegisterRun{0x012E, 1, value, read_write, 1, Limits{1, 32000}},       // 40303..40304 ZW
    RegisterRun{0x0130, 1, value, read_write, 0, Limits{0, 8000}},        // 40305..40306 ZT
    RegisterRun{0x0132, 1, value, read_write, 0, Limits{0, 1}},           // 40307..40308 PK
    RegisterRun{0x0134, 1, value, read_write, 0, Limits{0, 20}},          // 40309..40310 DD
    RegisterRun{0x0136, 1, value, read_write},                            // 40311..40312 MA
    RegisterRun{0x0138, 3, value, read_write, 0, Limits{0, 3000}},        // 40313..40318 CX, CY, CZ
    RegisterRun{0x013E, 1, value, read_write, 0, Limits{0, 30000}},       // 40319..40320 HT
    RegisterRun{0x0140, 1, value, read_write, 0, Limits{0, 5}},           // 40321..40322 YV
    RegisterRun{0x0142, 1, value, read_write, 0, Limits{0, 3}},           // 40323..40324 YR
    RegisterRun{0x0144, 2, value, read_write, 0, Limits{0, 30000}},       // 40325..40328 YM, YN
    RegisterRun{0x0148, 1, value, read_write, 0, Limits{0, 1}},           // 40329..40330 OT
    RegisterRun{0x014A, 1, value, read_write, 0, Limits{0, 3000}},        // 40331..40332 RT
    RegisterRun{0x014C, 2, word, read_write},                             // 40333..40334 reserved
    RegisterRun{0x014E, 1, value, read_write, 1, Limits{1, 30000}},       // 40335..40336 AM
    RegisterRun{0x0150, 1, value, read_write, 0, Limits{0, 24000}},       // 40337..40338 VM
    RegisterRun{0x0152, 2, value, read_write, 1, Limits{1, 30000}},       // 40339..40342 JA, JL
    RegisterRun{0x0156, 1, value, read_write, 0, Limits{-24000, 24000}},  // 40343..40344 JS
    RegisterRun{0x0158, 2, value, read_write, 1, Limits{1, 30000}},       // 40345..40348 AC, DE
    RegisterRun{0x015C, 1, value, read_write, 0, Limits{0, 24000}},       // 40349..40350 VE
    RegisterRun{0x015E, 2, value, read_write, 0,
                Limits{-2147483647, 2147483647}},                    // 40351..40354 DI, DC
    RegisterRun{0x0162, 1, value, read_write, 0, Limits{0, 24000}},  // 40355..40356 VC
    RegisterRun{0x0164, 1, value, read_write, 1, Limits{1, 30000}},  // 40357..40358 HA1
    RegisterRun{0x0166, 1, value, read_write},                       // 40359..40360 reserved
    RegisterRun{0x0168, 2, value, read_write, 0, Limits{0, 24000}},  // 40361..40364 HV1, HV2
    RegisterRun{0x016C, 1, value, read_write, 0,
                Limits{-2147483647, 2147483647}},                         // 40365..40366 HO
    RegisterRun{0x016E, 8, value, read_write, 0, Limits{-24000, 24000}},  // 40367..40382 JC1 to JC8
    RegisterRun{0x017E, 1, value, read_write, 0, Limits{0, 125}},         // 40383..40384 JT
    RegisterRun{0x0180, 1, value, read_write, 0, Limits{0, 1000}},        // 40385..40386 KJ
    RegisterRun{0x0182, 1, value, read_write, 0, Limits{0, 125}},         // 40387..40388 FF
    RegisterRun{0x0184, 1, value, read_write, 0, Limits{0, 24000}},       // 40389..40390 VT
    RegisterRun{0x0186, 8, word, read_write},                             // 40391..40398 reserved
    RegisterRun{0x018E, 2, value, read_write, 1, Limits{1, 2147483647}},  // 40399..40402 EN, EU
    RegisterRun{0x0192, 1, value, read_write, 0, Limits{0, 32000}},       // 40403..40404 SZ
    RegisterRun{0x0194, 1, value, read_write, 0, Limits{0, 31}},          // 40405..40406 PT
    RegisterRun{0x0196, 1, value, read_write, 0, Limits{0, 2147483647}},  // 40407..40408 PF
    RegisterRun{0x0198, 1, value, read_write, 200, Limits{200, 131072}},  // 40409..40410 EG
    RegisterRun{0x019A, 1, value, read_write, 0, Limits{0, 1}},           // 40411..40412 PV
    RegisterRun{0x019C, 2, value, read_write},                            // 40413..40416 reserved
    RegisterRun{0x01A0, 1, value, read_write, 1, Limits{1, 100}},         // 40417..40418 XT
    RegisterRun{0x01A2, 1, value, read_write, 0, Limits{0, 2147483647}},  // 40419..40420 XO
    RegisterRun{0x01A4, 1, value, read_write, 200, Limits{200, 100000}},  // 40421..40422 XR
    RegisterRun{0x01A6, 1, value, read_write, 0, Limits{0, 256}},         // 40423..40424 PO
    RegisterRun{0x01A8, 2, value, read_write, 0, Limits{0, 13107200}},    // 40425..40428 ON, OD
    RegisterRun{0x01AC, 1, value, read_write, 0, Limits{0, 3}},           // 40429..40430 ES
    RegisterRun{0x01AE, 1, value, read_write, 0, Limits{0, 1}},           // 40431..40432 PU
    RegisterRun{0x01B0, 8, word, read_write},                             // 40433..40440 reserved
    RegisterRun{0x01B8, 1, value, read_write},                            // 40441..40442 reserved
    RegisterRun{0x01BA, 1, value, read_write, 0, Limits{0, 24000}},       // 40443..40444 AG
    RegisterRun{0x01BC, 1, value, read_write, 0, Limits{0, 3000}},        // 40445..40446 AN
    RegisterRun{0x01BE, 2, value, read_write, 0, Limits{-10000, 10000}},  // 40447..40450 AV1, AV2
    RegisterRun{0x01C2, 2, value, read_write, 0, Limits{0, 255}},         // 40451..40454 AD1, AD2
    RegisterRun{0x01C6, 2, value, read_write, 1, Limits{1, 20000}},       // 40455..40458 AF1, AF2
    RegisterRun{0x01CA, 2, value, read_write, 0, Limits{-10000, 10000}},  // 40459..40462 AT1, AT2
    RegisterRun{0x01CE, 1, value, read_write, 0, Limits{0, 1}},           // 40463..40464 FA1
    RegisterRun{0x01D0, 4, value, read_write},                            // 40465..40472 reserved
    RegisterRun{0x01D8, 2, value, read_write, 1, Limits{1, 32000}},       // 40473..40476 OS1, OS2
    RegisterRun{0x01DC, 2, value, read_write, 0, Limits{0, 5}},           // 40477..40480 XA1, XA2
    RegisterRun{0x01E0, 10, word, read_write},                            // 40481..40490 reserved
    RegisterRun{0x01EA, 10, value, read_write, 0, Limits{0, 46}},         // 40491..40510 MU1 to MUA
    RegisterRun{0x01FE, 8, word, read_write},                             // 40511..40518 reserved
    RegisterRun{0x0206, 6, value, read_write, 0, Limits{0, 36}},          // 40519..40530 MO1 to MO6
    RegisterRun{0x0212, 8, word, read_write},                             // 40531..40538 reserved
    RegisterRun{0x021A, 2, value, read_write, 0, Limits{0, 32000}},       // 40539..40542 BD, BE
    RegisterRun{0x021E, 1, value, read_write},                            // 40543..40544 reserved
    RegisterRun{0x0220, 1, value, read_write, 0, Limits{0, 10}},          // 40545..40546 HX
    RegisterRun{0x0222, 10, value, read_write, 0, Limits{0, 8000}},       // 40547..40566 FI1 to FIA
    RegisterRun{0x0236, 1, value, read_write, 0, Limits{0, 2147483647}},  // 40567..40568 PL
    RegisterRun{0x0238, 2, value, read_write, 0, Limits{0, 32000}},       // 40569..40572 PD, PE
    RegisterRun{0x023C, 1, value, read_write, 0, Limits{0, 20000}},       // 40573..40574 TT
    RegisterRun{0x023E, 1, value, read_write, 24, Limits{24, 480}},       // 40575..40576 ZV
    RegisterRun{0x0240, 1, value, read_write, 24, Limits{24, 24000}},     // 40577..40578 VR
    RegisterRun{0x0242, 1, value, read_write, 0, Limits{0, 24000}},       // 40579..40580 VV
    RegisterRun{0x0244, 1, value, read_write, 0, Limits{0, 3000}},        // 40581..40582 TV
    RegisterRun{0x0246, 3, value, read_write, 0,
                Limits{-2147483647, 2147483647}},                   // 40583..40588 DG, LP, LM
    RegisterRun{0x024C, 1, value, read_write, 0, Limits{-4, 35}}};  // 40589..40590 HE

}  // namespace

RegisterMap moons_m3_registers() { return kM3; }

}  // namespace mbgate::sim

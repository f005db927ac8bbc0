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

}  // namespace mbgate::sim

// SPDX-License-Identifier: Apache-2.0
// The register tables of MOONS' drives ("Modbus User Manual", Appendix 5), one a series. Register
// numbers there are references: protocol address = number - 40001.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "sim/drives/register_bank.hpp"

namespace mbgate::sim {

enum class MoonsSeries : std::uint8_t {
  st,    ///< ST, STAC, STM, SWM: steppers
  stb,   ///< STB
  stf,   ///< STF
  ssdc,  ///< SSDC, SS, RS, SSM, TSM, TXM: step servos
  m2,    ///< M2: servo; has write-only values
  m3,    ///< M3: servo with a map of its own, almost all values
  mdx,   ///< MDX
  bldc   ///< BLDC: turns, but does not position
};

RegisterMap moons_st_registers();
RegisterMap moons_stb_registers();
RegisterMap moons_stf_registers();
RegisterMap moons_ssdc_registers();
RegisterMap moons_m2_registers();
RegisterMap moons_m3_registers();
RegisterMap moons_mdx_registers();
RegisterMap moons_bldc_registers();

RegisterMap moons_registers(MoonsSeries series);

/// Registers that all series except M3 have at the same address.
inline constexpr std::uint16_t kMoonsStatus = 0x0001;
inline constexpr std::uint16_t kMoonsPosition = 0x0006;
inline constexpr std::uint16_t kMoonsDistance = 0x001E;
/// Registers that all series have at the same address.
inline constexpr std::uint16_t kMoonsOpcode = 0x007C;
inline constexpr std::uint16_t kMoonsParameters = 0x007D;

/// The addresses of the registers of a series that do more than hold a value.
struct MoonsPlaces {
  std::uint16_t alarm = 0x0000;
  std::uint16_t status = kMoonsStatus;
  std::uint16_t encoder_position = 0x0004;
  std::uint16_t position = kMoonsPosition;
  std::optional<std::uint16_t> position_command = 0x0008;
  std::uint16_t velocity = 0x000A;
  std::uint16_t target_velocity = 0x000B;
  std::uint16_t relative_distance = 0x0013;
  std::uint16_t distance = kMoonsDistance;
  std::uint16_t jog_velocity = 0x0030;
  std::optional<std::uint16_t> protocol = std::nullopt;  ///< PR
  std::uint32_t status_bits = 0xFFFFFFFF;  ///< the status bits that the series has (Appendix 6)
};

const MoonsPlaces& moons_places(MoonsSeries series);

/// PR: word order and wiring in one setting (4.1.2).
inline constexpr std::uint16_t kMoonsProtocolLittle = 133;
/// The bit that is set in the two little-endian settings (133 and 389) and not in the two
/// big-endian ones (5 and 261).
inline constexpr std::uint32_t kMoonsLittleBit = 0x80;

// Ranges of registers of MOONS' drives. The manual prints none in its tables; what counts here is
// that a rate of 0 is none.

inline constexpr Limits kRate{1, 32000};
inline constexpr Limits kProtocol{1, 511};

/// What all series but M3 and BLDC begin with, and their motion registers.
inline constexpr std::array kMoonsStart{
    RegisterRun{0x0000, 1, Width::word, Access::read_only},          // 40001 AL
    RegisterRun{0x0001, 1, Width::word, Access::read_only, 0x0009},  // 40002 SC
    RegisterRun{0x0002, 2, Width::word, Access::read_only}};         // 40003..40004 IS, ISX
inline constexpr std::array kMoonsMotion{
    RegisterRun{0x000A, 2, Width::word, Access::read_only},       // 40011..40012 IV0, IV1
    RegisterRun{0x000C, 1, Width::word, Access::read_only, 400},  // 40013 IT
    RegisterRun{0x000D, 1, Width::word, Access::read_only, 240},  // 40014 IU
    RegisterRun{0x000E, 1, Width::value, Access::read_only},      // 40015..40016 IX
    RegisterRun{0x0010, 3, Width::word, Access::read_only},       // 40017..40019 IA, IC
    RegisterRun{0x0013, 2, Width::value, Access::read_only},      // 40020..40023 ID
    RegisterRun{0x0017, 4, Width::word, Access::read_only},       // 40024..40027 IA1, IA2, CM
    RegisterRun{0x001B, 3, Width::word, Access::read_write, 240, kRate},  // 40028..40030 AC, DE, VE
    RegisterRun{0x001E, 2, Width::value, Access::read_write},             // 40031..40034 DI, DC
    RegisterRun{0x0022, 1, Width::word, Access::read_write, 240, kRate},  // 40035 VC
    RegisterRun{0x0023, 5, Width::word, Access::read_only},               // 40036..40040
    RegisterRun{0x0028, 1, Width::value, Access::read_write}};            // 40041..40042

/// One table of several parts.
template <std::size_t... Sizes>
constexpr auto joined(const std::array<RegisterRun, Sizes>&... parts) {
  std::array<RegisterRun, (Sizes + ...)> all{};
  auto at = all.begin();
  ((at = std::copy(parts.begin(), parts.end(), at)), ...);
  return all;
}

}  // namespace mbgate::sim

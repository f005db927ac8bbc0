// SPDX-License-Identifier: Apache-2.0
// The register maps of the simulated drives, which were taken from the manuals without regard to
// the profiles: which register is a half of which value.
#pragma once

#include <string>

#include "modbus/request.hpp"
#include "sim/drives/maps/aic_map.hpp"
#include "sim/drives/maps/fda6000_map.hpp"
#include "sim/drives/maps/moons_map.hpp"
#include "sim/drives/maps/stepper_map.hpp"

namespace mbgate::test {

using sim::MoonsSeries;

struct Series {
  const char* profile;
  MoonsSeries series;
};

inline constexpr std::array kSeries{
    Series{"moons-st", MoonsSeries::st},   Series{"moons-stb", MoonsSeries::stb},
    Series{"moons-stf", MoonsSeries::stf}, Series{"moons-ssdc", MoonsSeries::ssdc},
    Series{"moons-m2", MoonsSeries::m2},   Series{"moons-m3", MoonsSeries::m3},
    Series{"moons-mdx", MoonsSeries::mdx}, Series{"moons-bldc", MoonsSeries::bldc}};

enum class Part : std::uint8_t { none, word, first_half, second_half };

struct Place {
  Part part = Part::none;
  const sim::RegisterRun* run = nullptr;
};

inline Place place_of(sim::RegisterMap map, std::uint32_t address) {
  for (const sim::RegisterRun& run : map) {
    const auto width = static_cast<unsigned>(run.width);
    if (address >= run.first && address < run.first + run.entries * width) {
      const bool second = (address - run.first) % width == 1;
      const Part half = second ? Part::second_half : Part::first_half;
      return {run.width == sim::Width::word ? Part::word : half, &run};
    }
  }
  return {};
}

/// Does the range begin or end between the halves of a value?
inline bool cuts_value(sim::RegisterMap map, const modbus::TableRange& range) {
  return place_of(map, range.first).part == Part::second_half ||
         place_of(map, std::uint32_t{range.first} + range.count).part == Part::second_half;
}

/// The simulated registers of a profile; empty where its drive has no such table.
inline sim::RegisterMap registers_of(const std::string& profile, modbus::Table table) {
  if (profile == "autonics-aic") {
    return sim::aic_registers(table);
  }
  if (table != modbus::Table::holding_registers) {
    return {};
  }
  if (profile == "rs485-stepper") {
    return sim::stepper_registers();
  }
  if (profile == "higen-fda6000") {
    return sim::fda6000_registers();
  }
  const auto* found = std::ranges::find(kSeries, profile, &Series::profile);
  return sim::moons_registers(found->series);
}

}  // namespace mbgate::test

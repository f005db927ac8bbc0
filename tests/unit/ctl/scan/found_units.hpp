// SPDX-License-Identifier: Apache-2.0
// What a scan may find, for tests of how it is told.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "ctl/scan/scan.hpp"
#include "profile_device.hpp"

namespace mbgate::ctl {

inline FoundUnit found(std::uint8_t unit, const std::vector<std::string>& profiles) {
  FoundUnit result{unit, {}, std::chrono::microseconds(3500)};
  auto& identification = result.identification;
  for (const auto& name : profiles) {
    identification.likely.push_back(shipped_profiles().find(name));
  }
  identification.nearest = shipped_profiles().find("moons-m2");
  identification.fitting = 9;
  identification.judged = 9;
  identification.functions.set(3);
  return result;
}

/// A unit of every kind: named for certain, word order unknown, two kinds, a text, none that fits.
inline ScanResult plant() {
  ScanResult result;
  result.found.push_back(found(1, {"moons-st"}));
  result.found.push_back(found(3, {"moons-m3"}));
  result.found.back().identification.word_order = drive::WordOrder::little;
  result.found.push_back(found(4, {"moons-ssdc", "moons-stb"}));
  result.found.back().identification.word_order = drive::WordOrder::big;
  result.found.push_back(found(17, {"autonics-aic"}));
  result.found.back().identification.word_order = drive::WordOrder::big;
  result.found.back().identification.texts = {{"model name", "AiC-D-56LA"}};
  result.found.push_back(found(32, {}));
  result.found.back().identification.fitting = 4;
  result.found.back().slowest = std::chrono::milliseconds(120);
  result.found.back().fell_silent = true;
  return result;
}

}  // namespace mbgate::ctl

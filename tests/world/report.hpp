// SPDX-License-Identifier: Apache-2.0
// What a run has to tell: how often what happened, and the texts of the first violations.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "bus/instant.hpp"

namespace mbgate::world {

struct Report {
  using Counts = std::map<std::string, std::uint64_t>;

  std::uint64_t transactions = 0;  ///< transmissions
  std::uint64_t requests = 0;
  std::uint64_t answers = 0;  ///< good ones
  bus::Duration virtual_time{0};
  Counts exceptions;  ///< by code
  Counts faults;
  Counts apart;  ///< what physics leaves uncertain
  Counts violations;
  std::vector<std::string> texts;

  void fault(const char* kind) { ++faults[kind]; }
  void violation(const std::string& kind, const std::string& text) {
    constexpr std::uint64_t kMostTexts = 3;
    if (++violations[kind] <= kMostTexts) {
      texts.push_back(kind + ": " + text);
    }
  }
  /// Takes in another run's figures, and its texts.
  void add(const Report& other);
  /// Everything but the real time, which differs from run to run.
  [[nodiscard]] std::string summary() const;
};

}  // namespace mbgate::world

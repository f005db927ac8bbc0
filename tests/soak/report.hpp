// SPDX-License-Identifier: Apache-2.0
// What a run has to tell: faults and violations by kind, and the texts of the first violations.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "bus/instant.hpp"

namespace mbgate::soak {

struct Report {
  std::uint64_t transmissions = 0;
  std::uint64_t framing_lost = 0;  ///< connections that were closed for that
  std::uint64_t requests = 0;
  std::uint64_t answers = 0;  ///< positive ones
  std::uint64_t exceptions = 0;
  bus::Duration virtual_time{0};
  std::map<std::string, std::uint64_t> faults;
  std::map<std::string, std::uint64_t> violations;
  /// What the contract cannot exclude, counted apart: lateness beyond the quarantine in force, and
  /// what an adapter kept while the line seemed silent.
  std::map<std::string, std::uint64_t> apart;
  /// Of these, what a device's lateness or second answers cost until they were known: by address,
  /// opening of the line and start.
  std::map<std::string, std::uint64_t> starts;
  std::map<unsigned, std::uint64_t> codes;  ///< exceptions by code
  /// Why the gateway answered 06, 0A or 0B by itself: what these requests met.
  std::map<std::string, std::uint64_t> reasons;
  std::vector<std::string> texts;  ///< of the first violations of each kind

  void fault(const char* kind) { ++faults[kind]; }
  void violation(const std::string& kind, const std::string& text) {
    if (++violations[kind] <= kMostTexts) {
      texts.push_back(kind + ": " + text);
    }
  }
  [[nodiscard]] std::uint64_t violation_count() const;
  /// Takes in another run's figures.
  void add(const Report& other);
  /// Everything but the real time, which differs from run to run.
  [[nodiscard]] std::string summary() const;

 private:
  static constexpr std::uint64_t kMostTexts = 3;
};

}  // namespace mbgate::soak

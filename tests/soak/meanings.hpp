// SPDX-License-Identifier: Apache-2.0
// What the units of listeners lead to by the settings in force, and how it is understood there. A
// request that was read before its unit came to mean something else is not carried out.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "soak/plan.hpp"

namespace mbgate::soak {

class Meanings {
 public:
  explicit Meanings(const SoakPlan& plan) : plan_(plan), now_(in_force()) {}

  void after_reload(Instant now);
  /// The last time that it came to mean something else.
  [[nodiscard]] Instant changed_at(std::size_t listener, std::uint8_t unit) const;

 private:
  using Unit = std::pair<std::size_t, std::uint8_t>;
  using Meaning = std::vector<std::size_t>;  ///< nothing but these makes a difference
  [[nodiscard]] std::map<Unit, Meaning> in_force() const;
  [[nodiscard]] Meaning of(const Door& door) const;
  void add_device(Meaning& meaning, std::size_t index) const;

  const SoakPlan& plan_;
  std::map<Unit, Meaning> now_;
  std::map<Unit, Instant> changed_at_;
};

}  // namespace mbgate::soak

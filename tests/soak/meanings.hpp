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
  explicit Meanings(const SoakPlan& plan)
      : plan_(plan), now_(in_force()), are_away_(plan.absent.listeners) {}

  /// The last time that a unit came to mean something else.
  struct Change {
    Instant at = Instant::min();
    Instant surely = Instant::min();
  };

  void after_reload(Instant now);
  [[nodiscard]] Change change_of(std::size_t listener, std::uint8_t unit) const;

 private:
  using Unit = std::pair<std::size_t, std::uint8_t>;
  using Meaning = std::vector<std::size_t>;  ///< nothing but these makes a difference
  [[nodiscard]] std::map<Unit, Meaning> in_force() const;
  [[nodiscard]] Meaning of(const Door& door) const;
  void add_device(Meaning& meaning, std::size_t index) const;

  const SoakPlan& plan_;
  std::map<Unit, Meaning> now_;
  std::vector<bool> are_away_;  ///< listeners, by the settings in force
  std::map<Unit, Change> changes_;
};

}  // namespace mbgate::soak

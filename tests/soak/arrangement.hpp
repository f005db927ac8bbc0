// SPDX-License-Identifier: Apache-2.0
// The plan's settings as a user wrote them down: what is there at present, in any order. Numbers
// are the places in the plan, because all of it is there when the gateway begins.
#pragma once

#include <utility>

#include "soak/plan.hpp"

namespace mbgate::soak {

class Arrangement {
 public:
  using Places = std::vector<std::size_t>;
  /// In the plan's own order.
  explicit Arrangement(const SoakPlan& plan);
  /// In an order that chance gives.
  Arrangement(const SoakPlan& plan, Random& random);

  /// To be asked once: they are given away.
  [[nodiscard]] gateway::Settings take_settings() { return std::move(settings_); }
  /// Where it is written down; nothing: it is absent.
  [[nodiscard]] std::optional<std::size_t> place_of_bus(std::size_t of_plan) const;
  [[nodiscard]] std::optional<std::size_t> place_of_device(std::size_t of_plan) const;

 private:
  Arrangement(const SoakPlan& plan, Random* random);
  void add_devices(const SoakPlan& plan);
  void add_routes(const SoakPlan& plan, const Places& order);
  void add_rules(const SoakPlan& plan);

  gateway::Settings settings_;
  Places listeners_;  // what stands where
  Places buses_;
  Places devices_;
};

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
// The plan's settings as a user wrote them down: what is there at present, in any order. The
// gateway numbers things by their places there, the soak by their places in the plan.
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
  /// Nothing: it is absent.
  [[nodiscard]] std::optional<gateway::BusId> bus(std::size_t of_plan) const;
  [[nodiscard]] std::optional<gateway::ListenerId> listener(std::size_t of_plan) const;
  [[nodiscard]] std::optional<std::size_t> device(std::size_t of_plan) const;
  [[nodiscard]] std::size_t plan_bus(gateway::BusId bus) const {
    return buses_[static_cast<std::size_t>(bus)];
  }

 private:
  Arrangement(const SoakPlan& plan, Random* random);
  void add_devices(const SoakPlan& plan);
  void add_routes(const SoakPlan& plan, const Places& order);

  gateway::Settings settings_;
  Places listeners_;  // what stands where
  Places buses_;
  Places devices_;
};

}  // namespace mbgate::soak

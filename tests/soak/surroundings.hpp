// SPDX-License-Identifier: Apache-2.0
// What every part of the plant can reach.
#pragma once

#include <functional>

#include "soak/oracle.hpp"
#include "soak/random.hpp"

namespace mbgate::soak {

struct Surroundings {
  const SoakPlan& plan;
  Schedule& schedule;
  Random& random;
  Report& report;
  Oracle& oracle;
  Oracle::Devices& devices;
  /// Hands bytes of a bus to the gateway.
  std::function<void(std::size_t, Bytes)> deliver;
};

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
// What every part of the plant can reach.
#pragma once

#include <functional>

#include "soak/from_world.hpp"
#include "soak/oracle.hpp"

namespace mbgate::soak {

struct Surroundings {
  const SoakPlan& plan;
  Schedule& schedule;
  Random& random;
  Report& report;
  Oracle& oracle;
  Oracle::Devices& devices;
  /// Hands bytes of a bus to the kernel.
  std::function<void(std::size_t, const std::vector<std::uint8_t>&)> deliver;
  /// The far end of a TCP bus closes the connection; it has `answered` something on it.
  std::function<void(std::size_t, bool answered)> hang_up;
  /// What it has sent is no Modbus any more.
  std::function<void(std::size_t)> framing_lost;
};

}  // namespace mbgate::soak

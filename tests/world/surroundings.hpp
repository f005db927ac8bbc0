// SPDX-License-Identifier: Apache-2.0
// What the wires and clients of a plant can reach.
#pragma once

#include <functional>

#include "world/drive.hpp"
#include "world/report.hpp"

namespace mbgate::world {

struct Surroundings {
  const Plan& plan;
  Schedule& schedule;
  Ledger& ledger;
  Report& report;
  std::vector<Drive>& drives;
  /// Bytes of a bus have reached the kernel.
  std::function<void(std::size_t bus, const Octets& bytes, const Came& came)> deliver;
  /// The far end of a TCP bus closes its connection.
  std::function<void(std::size_t bus)> hang_up;
};

}  // namespace mbgate::world

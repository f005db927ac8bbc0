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

/// What wires of both kinds have.
class AnyWire {
 protected:
  AnyWire(std::size_t bus, Surroundings& around, std::uint64_t salt)
      : bus_(bus),
        around_(around),
        random_(around.plan.seed ^ (salt + bus)),
        plan_(around.plan.lines[bus]) {}
  bool happens(unsigned permille, const char* kind) {
    if (permille == 0 || is_calm_ || !random_.chance(permille)) {
      return false;
    }
    around_.report.fault(kind);
    return true;
  }

  std::size_t bus_;
  Surroundings& around_;
  Random random_;
  LinePlan plan_;
  std::uint64_t epoch_ = 0;
  bool is_open_ = false;
  bool is_calm_ = false;
};

}  // namespace mbgate::world

// SPDX-License-Identifier: Apache-2.0
// Drives that boot because of what they were told, one of them or all: until then they get nothing
// but stops.
#pragma once

#include "soak/flight.hpp"

namespace mbgate::soak {

class Oracle;

class BootRules {
 public:
  explicit BootRules(Oracle& oracle) : oracle_(oracle) {}

  /// To be called when it is known when it ends.
  void take(const Flight& flight) const {
    check(flight);
    note(flight);
  }

 private:
  void check(const Flight& flight) const;
  void note(const Flight& flight) const;

  Oracle& oracle_;
};

}  // namespace mbgate::soak

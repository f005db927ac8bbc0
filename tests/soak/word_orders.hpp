// SPDX-License-Identifier: Apache-2.0
// What is known of the word orders that drives are set to. A drive that was silent, or is reached
// by a line that was opened anew, may be another one, and one that was told otherwise has another
// setting: before values are written it is asked again.
#pragma once

#include <cstdint>

#include "soak/flight.hpp"

namespace mbgate::soak {

class Oracle;

class WordOrders {
 public:
  explicit WordOrders(Oracle& oracle) : oracle_(oracle) {}

  /// Something else is transmitted on the bus now.
  void after_wait(std::size_t bus) const;
  /// A drive, or all who hear it, may have another setting from now on.
  void note_told(const Flight& flight) const;
  void forget_line(std::size_t bus) const;
  /// Other settings say of the drive something else, or that another one is there.
  void forget(std::size_t bus, std::uint8_t address) const;

 private:
  Oracle& oracle_;
};

}  // namespace mbgate::soak

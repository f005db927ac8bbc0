// SPDX-License-Identifier: Apache-2.0
// What a request touches of devices, as access rules see it: its reading and its writing half.
#pragma once

#include <optional>
#include <vector>

#include "soak/asked.hpp"
#include "soak/specification.hpp"

namespace mbgate::soak {

/// Of what a request writes: no stop, one among others or perhaps one, or a stop alone, with its
/// parameters.
enum class StopAmong : std::uint8_t { none, others, alone };

/// What a part of a request touches of a device.
struct Touched {
  std::optional<std::size_t> device;
  std::optional<spec::Range> range;
  StopAmong stop = StopAmong::none;
};

/// One half of a request. Of one that cannot be carried out only its function is known.
struct Half {
  bool reads = false;
  bool is_known = true;
  std::vector<Touched> touched{};
};

[[nodiscard]] std::vector<Half> halves_of(const SoakPlan& plan, const Asked& asked);

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
// One run: a plant, a subject, its clients; for a while, and what was seen.
#pragma once

#include <optional>

#include "bus_simulator.hpp"
#include "subject.hpp"

namespace mbgate::bench {

struct RunResult {
  double seconds = 0;
  std::vector<WireFigures> buses;
  LoadFigures clients;                       ///< of a master: what the wire saw, in its place
  Usage used;                                ///< while measured; `resident` at its end
  std::optional<std::uint64_t> allocations;  ///< while measured
  std::uint64_t handshakes = 0;              ///< over TLS, while measured
};

/// Throws std::runtime_error.
RunResult run_once(const Scenario& scenario, const Means& means, const Times& times);

}  // namespace mbgate::bench

// SPDX-License-Identifier: Apache-2.0
// The clients: plain sockets that ask for registers, one request after the answer to the last, and
// look at every answer.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "plant.hpp"
#include "sys/unique_fd.hpp"
#include "tls.hpp"

namespace mbgate::bench {

/// Who asks for what.
struct LoadSettings {
  unsigned clients = 8;
  unsigned outstanding = 1;  ///< requests of each that are not answered yet
  bool same = false;         ///< all read the same registers; else each its own
  unsigned idle = 0;         ///< connections besides that say nothing
  unsigned flood = 0;        ///< connections to the flood's port that send garbage without end
  bool tls = false;          ///< clients and idle connections speak TLS
  unsigned handshakes = 0;   ///< processes that shake hands at a port of their own without end

  [[nodiscard]] bool speaks_tls() const { return tls || handshakes > 0; }
};

/// What the clients ask with.
struct Doors {
  std::vector<std::uint16_t> ports;  ///< on 127.0.0.1, one a bus
  std::optional<TlsFiles> tls;       ///< none: plain TCP
};

/// What the clients saw. Plain data: it comes through a pipe.
struct LoadFigures {
  std::uint64_t answers = 0;
  std::uint64_t exceptions = 0;  ///< answers that were one, counted apart
  std::uint64_t wrong = 0;       ///< answers that were not to the request, or of other registers
  std::uint64_t lost = 0;        ///< connections that the other side closed or reset, idle ones too
  std::uint64_t unanswered = 0;  ///< requests without an answer for 5 s, or half of the time
  Spread latency;                ///< of the answers, from the request's send() on
  double seconds = 0;            ///< for which this was counted
};

struct Times {
  Nanoseconds warm_up;
  Nanoseconds measured;
};

/// The clients go round the ports, and on each bus round the devices.
/// Connects, works for the warm-up, writes 'B' to `output`, works for the time that is measured,
/// writes its LoadFigures.
/// Throws std::system_error if it cannot connect.
void run_load(const LoadSettings& settings, const Plant& plant, const Doors& doors,
              const Times& times, int output);

/// Sends garbage to a port until it is killed: as much as the other side takes, and connects again
/// as soon as that closes.
void run_flood(unsigned connections, std::uint16_t port);

/// Connects to a port of 127.0.0.1; throws std::system_error.
sys::UniqueFd connect_to(std::uint16_t port);

}  // namespace mbgate::bench

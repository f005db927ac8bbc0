// SPDX-License-Identifier: Apache-2.0
// One seed's plant: the gateway's settings, the doors through which clients reach devices, and how
// often what goes wrong.
#pragma once

#include <optional>
#include <vector>

#include "gateway/settings.hpp"
#include "soak/random.hpp"

namespace mbgate::soak {

/// Client addresses of the windows: the first shows holding registers, the second input registers.
inline constexpr std::uint16_t kHoldingWindow = 1000;
inline constexpr std::uint16_t kInputWindow = 3000;
inline constexpr std::uint16_t kInputs = 100;

/// A unit of a listener, as its clients see it.
struct Door {
  std::size_t listener = 0;
  std::uint8_t unit = 0;
  std::optional<std::size_t> device;  ///< none: a broadcast
  std::vector<std::size_t> buses;
  bool routed = false;    ///< what the device's profile says is done
  bool windowed = false;  ///< only the two windows can be reached
  bool swapped = false;   ///< the client sees the words of values the other way round
  bool read_only = false;
  Duration read_deadline{0};
  Duration write_deadline{0};
  bool replies = true;  ///< broadcasts: the client gets an echo
};

/// In thousandths, of answers unless it says otherwise.
struct FaultRates {
  unsigned late = 0;
  unsigned twice = 0;
  unsigned never = 0;
  unsigned garbage = 0;
  unsigned wrong_unit = 0;
  unsigned wrong_function = 0;
  unsigned bad_crc = 0;
  unsigned damaged = 0;  ///< bits flipped, bytes lost or doubled on the way to the gateway
  unsigned pieces = 0;
  unsigned too_long = 0;
  unsigned babble = 0;
  unsigned exception = 0;
  unsigned early = 0;
  unsigned request_damaged = 0;     ///< of requests
  unsigned wrong_echo = 0;          ///< of requests
  unsigned unknown_identifier = 0;  ///< of TCP answers: one more of nobody's goes before
  Duration noise_every{0};          ///< 0: never
  Duration foreign_every{0};
  Duration lost_every{0};
  Duration dead_every{0};
};

/// How a client behaves.
struct Manners {
  std::size_t listener = 0;
  unsigned host = 0;
  unsigned burst = 1;        ///< requests at once, at most
  unsigned outstanding = 1;  ///< it waits for answers beyond
  Duration pause{0};         ///< between bursts, at most
  unsigned writes = 0;       ///< thousandths of its requests
  unsigned stops = 0;
  unsigned broadcasts = 0;
  unsigned malformed = 0;
  unsigned foreign = 0;
  unsigned splits = 0;
  unsigned stalls = 0;  ///< thousandths of its bursts, as the following
  unsigned vanishes = 0;
  unsigned half_closes = 0;
  std::uint16_t same_reads = 0;  ///< thousandths that ask for what everybody asks for
};

struct SoakPlan {
  gateway::Settings settings;
  std::vector<Door> doors;
  std::vector<FaultRates> rates;  ///< by bus
  std::vector<Manners> clients;
  bool beyond = false;  ///< devices are later than the quarantine: misdeliveries are counted apart
};

SoakPlan draw_plan(Random& random);
/// Its last step: who asks, and how.
void draw_clients(SoakPlan& plan, Random& random);

}  // namespace mbgate::soak

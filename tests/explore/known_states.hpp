// SPDX-License-Identifier: Apache-2.0
// The states that were seen, by their digests, and with how much slack each was gone through: an
// open hash table, because there are many millions of them.
#pragma once

#include <cstdint>
#include <vector>

#include "explore/state_hash.hpp"

namespace mbgate::explore {

/// One bit for each slack that a state was gone through with.
using SlackSet = std::uint32_t;
inline constexpr unsigned kMostSlacks = 32;

class KnownStates {
 public:
  KnownStates() : places_(kFirstSize) {}

  /// Remembers `slack`, unless the state was gone through with one of `covering`. True: it was not.
  bool add(const Digest& state, SlackSet slack, SlackSet covering) {
    if (4 * size_ >= 3 * places_.size()) {  // fuller, and a search becomes long
      grow();
    }
    Place& place = place_of(state.first, static_cast<std::uint32_t>(state.second >> kHalf));
    if ((place.gone_through & covering) != 0) {
      return false;
    }
    size_ += place.gone_through == 0 ? 1U : 0U;
    place.first = state.first;
    place.second = static_cast<std::uint32_t>(state.second >> kHalf);
    place.gone_through |= slack;
    return true;
  }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t bytes() const { return places_.size() * sizeof(Place); }

 private:
  static constexpr std::size_t kFirstSize = 1U << 16U;
  static constexpr unsigned kHalf = 32;

  // 96 bits of a digest: two among 10^9 states are the same with a probability of 10^-11.
  struct Place {
    std::uint64_t first = 0;
    std::uint32_t second = 0;
    SlackSet gone_through = 0;  // none: an empty place
  };

  // Its own place, or the empty one where it belongs.
  Place& place_of(std::uint64_t first, std::uint32_t second) {
    std::size_t at = static_cast<std::size_t>(first ^ first >> kHalf) & (places_.size() - 1);
    while (places_[at].gone_through != 0 &&
           (places_[at].first != first || places_[at].second != second)) {
      at = (at + 1) & (places_.size() - 1);
    }
    return places_[at];
  }
  void grow() {
    std::vector<Place> before(2 * places_.size());
    before.swap(places_);
    for (const Place& place : before) {
      if (place.gone_through != 0) {
        place_of(place.first, place.second) = place;
      }
    }
  }

  std::vector<Place> places_;  // a power of two
  std::size_t size_ = 0;
};

}  // namespace mbgate::explore

// SPDX-License-Identifier: Apache-2.0
// The states that were seen, by their digests, and with how much slack each was gone through: open
// hash tables, because there are many millions of them, each small enough to grow beside the
// others.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <numeric>
#include <vector>

#include "explore/state_hash.hpp"

namespace mbgate::explore {

/// One bit for each slack that a state was gone through with.
using SlackSet = std::uint32_t;
inline constexpr unsigned kMostSlacks = 32;

class KnownStates {
 public:
  /// Remembers `slack`, unless the state was gone through with one of `covering`. True: it was not.
  bool add(const Digest& state, SlackSet slack, SlackSet covering) {
    return tables_[state.second % kTables].add(
        {state.first, static_cast<std::uint32_t>(state.second >> kHalf), slack}, covering);
  }
  [[nodiscard]] std::size_t bytes() const {
    return std::transform_reduce(tables_.begin(), tables_.end(), std::size_t{0}, std::plus<>{},
                                 [](const Table& table) { return table.bytes(); });
  }

 private:
  static constexpr std::size_t kTables = 256;
  static constexpr unsigned kHalf = 32;

  // 104 bits of a digest (8 of them choose the table): two among 10^9 states are the same with a
  // probability of 10^-13.
  struct Place {
    std::uint64_t first = 0;
    std::uint32_t second = 0;
    SlackSet gone_through = 0;  // none: an empty place
  };

  class Table {
   public:
    bool add(const Place& state, SlackSet covering) {
      if (8 * size_ >= 7 * places_.size()) {  // fuller, and a search becomes long
        grow();
      }
      Place& place = place_of(state);
      if ((place.gone_through & covering) != 0) {
        return false;
      }
      size_ += place.gone_through == 0 ? 1U : 0U;
      place = {state.first, state.second, place.gone_through | state.gone_through};
      return true;
    }
    [[nodiscard]] std::size_t bytes() const { return places_.size() * sizeof(Place); }

   private:
    static constexpr std::size_t kFirstSize = 1U << 8U;

    // Its own place, or the empty one where it belongs.
    Place& place_of(const Place& state) {
      std::size_t at = (state.first >> kHalf) * places_.size() >> kHalf;
      while (places_[at].gone_through != 0 &&
             (places_[at].first != state.first || places_[at].second != state.second)) {
        at = at + 1 == places_.size() ? 0 : at + 1;
      }
      return places_[at];
    }
    void grow() {
      std::vector<Place> before(places_.size() + places_.size() / 2);
      before.swap(places_);
      for (const Place& place : before) {
        if (place.gone_through != 0) {
          place_of(place) = place;
        }
      }
    }

    std::vector<Place> places_ = std::vector<Place>(kFirstSize);
    std::size_t size_ = 0;
  };

  std::array<Table, kTables> tables_;
};

}  // namespace mbgate::explore

// SPDX-License-Identifier: Apache-2.0
// The states that were seen, by their digests, and what is to be remembered of each: an open hash
// table, because there are many millions of them.
#pragma once

#include <cstdint>
#include <vector>

#include "explore/state_hash.hpp"

namespace mbgate::explore {

class KnownStates {
 public:
  KnownStates() : places_(kFirstSize) {}

  /// True: it was not known.
  bool add(const Digest& state) {
    if (4 * size_ >= 3 * places_.size()) {  // fuller, and a search becomes long
      grow();
    }
    Digest& place = find(state);
    if (place == state) {
      return false;
    }
    place = state;
    ++size_;
    return true;
  }
  [[nodiscard]] bool has(const Digest& state) const { return places_[place_of(state)] == state; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t bytes() const { return places_.size() * sizeof(Digest); }

 private:
  static constexpr std::size_t kFirstSize = 1U << 16U;

  // Its own place, or the empty one where it belongs. The digest of nothing is no state's.
  [[nodiscard]] std::size_t place_of(const Digest& state) const {
    std::size_t at =
        static_cast<std::size_t>(state.first ^ state.first >> 32U) & (places_.size() - 1);
    while (places_[at] != Digest{} && places_[at] != state) {
      at = (at + 1) & (places_.size() - 1);
    }
    return at;
  }
  Digest& find(const Digest& state) { return places_[place_of(state)]; }
  void grow() {
    std::vector<Digest> before(2 * places_.size());
    before.swap(places_);
    for (const Digest& state : before) {
      if (state != Digest{}) {
        find(state) = state;
      }
    }
  }

  std::vector<Digest> places_;  // a power of two
  std::size_t size_ = 0;
};

}  // namespace mbgate::explore

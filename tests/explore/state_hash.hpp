// SPDX-License-Identifier: Apache-2.0
// A state as a number of 128 bits. What decides nothing must not tell two states apart: instants
// count from now, numbers of which only the order matters by their rank, and objects by the order
// in which they are met.
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <concepts>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "bus/instant.hpp"

namespace mbgate::explore {

using bus::Duration;
using bus::Instant;

struct Digest {
  std::uint64_t first = 0;
  std::uint64_t second = 0;
  auto operator<=>(const Digest&) const = default;
};

/// What the explorer's own reasoning rests on. If it does not hold, what was explored proves
/// nothing.
inline void require(bool holds, const char* what) {
  if (!holds) {
    throw std::logic_error(std::string("the explorer's reasoning does not hold: ") + what);
  }
}

/// No small world lives so long from its first request on; nothing that is older decides anything:
/// an instant counts as long as anything does.
inline constexpr Duration kFarPast = std::chrono::seconds(50);
/// No request is open for so long, unless its deadline is nearer than that.
inline constexpr Duration kAnsweredBy = std::chrono::seconds(25);

/// Numbers that are compared with each other, and with no others.
enum class Order : std::uint8_t { acceptance, turn, cached_writes, event };

class StateHash {
 public:
  explicit StateHash(Instant now) : now_(now) {}
  [[nodiscard]] Instant now() const { return now_; }

  template <typename Value>
  requires std::integral<Value> || std::is_enum_v<Value>
  void add(Value value) { mix(static_cast<std::uint64_t>(value)); }
  void add(Duration value) { mix(static_cast<std::uint64_t>(value.count())); }
  template <typename Value>
  void add(const std::optional<Value>& value) {
    add(value.has_value());
    if (value) {
      add(*value);
    }
  }
  void add(std::span<const std::uint8_t> bytes) {
    mix(bytes.size());
    for (const std::uint8_t byte : bytes) {
      mix(byte);
    }
  }
  /// An instant that is only compared with later ones once it is past: how long it is past is all
  /// the same.
  void until(Instant instant) { since(instant, Duration{0}); }
  /// An instant to which at most `reach` is ever added before it is compared: beyond that it is
  /// past for everybody.
  void since(Instant instant, Duration reach) {
    add(instant <= now_ - reach ? -reach : instant - now_);
  }
  /// The deadline of a request that was accepted `since` then. Requests are answered in less than
  /// kAnsweredBy, which the oracle requires, so that nothing comes near to a longer one.
  void deadline(Instant instant, Instant since) {
    add(instant - since > kAnsweredBy ? kAnsweredBy + Duration{1} : instant - now_);
  }
  /// A number of which only the order among those of its kind matters; 0 is none.
  void ordered(Order order, std::uint64_t number) {
    ordered_[static_cast<std::size_t>(order)].push_back(number);
  }
  /// An object: which one it is, counted in the order in which they are met. True: for the first
  /// time, and what it holds is still to be added.
  bool name(const void* object) {
    const auto known = std::ranges::find(named_, object);
    mix(static_cast<std::uint64_t>(known - named_.begin()));
    if (object == nullptr || known != named_.end()) {
      return false;
    }
    named_.push_back(object);
    return true;
  }
  [[nodiscard]] Digest digest() {
    for (const std::vector<std::uint64_t>& numbers : ordered_) {
      add_ranks(numbers);
    }
    mix(0);  // the last one counts as much as others
    return {first_, second_};
  }

 private:
  static constexpr std::size_t kOrders = 4;

  void add_ranks(const std::vector<std::uint64_t>& numbers) {
    sorted_.assign(numbers.begin(), numbers.end());
    sorted_.push_back(0);
    std::ranges::sort(sorted_);
    const auto repeated = std::ranges::unique(sorted_);
    sorted_.erase(repeated.begin(), repeated.end());
    for (const std::uint64_t number : numbers) {
      mix(static_cast<std::uint64_t>(std::ranges::lower_bound(sorted_, number) - sorted_.begin()));
    }
  }
  // Two halves that have nothing in common; each step of each can be undone, so that nothing is
  // lost on the way.
  void mix(std::uint64_t value) {
    first_ = (first_ ^ value) * 0x9E37'79B9'7F4A'7C15U;
    first_ ^= first_ >> 29U;
    second_ = (second_ + value + 0x632B'E59B'D9B4'E019U) * 0xD6E8'FEB8'6659'FD93U;
    second_ ^= second_ >> 32U;
  }

  Instant now_;
  std::uint64_t first_ = 0;
  std::uint64_t second_ = 0;
  std::array<std::vector<std::uint64_t>, kOrders> ordered_;
  std::vector<std::uint64_t> sorted_;
  std::vector<const void*> named_{nullptr};
};

}  // namespace mbgate::explore

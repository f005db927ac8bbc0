// SPDX-License-Identifier: Apache-2.0
#include "world/registers.hpp"

#include <algorithm>

namespace mbgate::world {
namespace {

// Finalizer of the SplitMix64 generator: every bit of the input moves every bit of the output.
std::uint64_t mixed(std::uint64_t value) {
  value = (value ^ (value >> 30U)) * 0xBF58476D1CE4E5B9U;
  value = (value ^ (value >> 27U)) * 0x94D049BB133111EBU;
  return value ^ (value >> 31U);
}

std::uint64_t ticks(Instant at) {
  return static_cast<std::uint64_t>(at.time_since_epoch() / std::chrono::milliseconds(1));
}

std::uint16_t word(std::uint64_t value) { return static_cast<std::uint16_t>(value & 0xFFFFU); }

unsigned key(Table table, unsigned address) {
  return static_cast<unsigned>(table) * kTableEnd + address;
}

}  // namespace

std::uint16_t Registers::salt(Table table, unsigned address) const {
  const std::uint16_t salted = word(mixed(salt_ + key(table, address)));
  return is_bits(table) ? salted & 1U : salted;
}

const Registers::History* Registers::history(Table table, unsigned address) const {
  const auto found = written_.find(key(table, address));
  return found == written_.end() ? nullptr : &found->second;
}

std::uint16_t Registers::read(Table table, unsigned address, Instant at) const {
  if (is_live(table, address)) {
    return word(salt(table, address) + ticks(at));
  }
  const History* versions = history(table, address);
  return versions == nullptr ? salt(table, address) : versions->back().value;
}

void Registers::write(Table table, unsigned address, std::uint16_t value, Instant at) {
  if (is_live(table, address)) {
    return;
  }
  History& versions = written_[key(table, address)];
  if (versions.empty()) {
    versions.push_back({Instant::min(), salt(table, address)});
  }
  versions.push_back({at, value});
}

bool Registers::held(Table table, unsigned first, std::span<const std::uint16_t> words,
                     Span span) const {
  if (words.size() == 1 && is_live(table, first)) {
    const std::uint64_t begin = ticks(span.first);
    return word(words[0] - salt(table, first) - begin) <= ticks(span.last) - begin;
  }
  std::vector<Instant> candidates{span.first};
  for (unsigned at = 0; at < words.size(); ++at) {
    if (const History* versions = history(table, first + at)) {
      for (auto it = versions->rbegin(); it != versions->rend() && it->since > span.first; ++it) {
        if (it->since <= span.last) {
          candidates.push_back(it->since);
        }
      }
    }
  }
  const auto holds = [&](unsigned at, Instant instant) {
    const History* versions = history(table, first + at);
    if (versions == nullptr) {
      return salt(table, first + at) == words[at];
    }
    // Of what was written at one instant it held each for a moment.
    for (auto it = versions->rbegin(); it != versions->rend(); ++it) {
      if (it->since <= instant && it->value == words[at]) {
        return true;
      }
      if (it->since < instant) {
        return false;
      }
    }
    return false;
  };
  return std::ranges::any_of(candidates, [&](Instant instant) {
    for (unsigned at = 0; at < words.size(); ++at) {
      if (!holds(at, instant)) {
        return false;
      }
    }
    return true;
  });
}

}  // namespace mbgate::world

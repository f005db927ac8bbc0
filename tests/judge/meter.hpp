// SPDX-License-Identifier: Apache-2.0
// What the clients of a plant get, in figures.
#pragma once

#include <algorithm>
#include <map>

#include "world/world.hpp"

namespace mbgate::judge {

using namespace world;  // NOLINT(google-build-using-namespace): it is about nothing else

class Meter : public Witness {
 public:
  explicit Meter(World& world) : world_(world), back_(world.plan().stations.size(), kNever) {}

  void given(Id id) override { open_[id] = world_.now(); }
  void answered(Id id) override {
    const Asked& asked = world_.ledger().asked[id];
    const unsigned host = world_.ledger().connections[asked.connection].host;
    open_.erase(id);
    if (asked.answer[0] < 0x80) {
      ++good[host];
      back_[*asked.intent.station] = std::min(back_[*asked.intent.station], world_.now());
    }
    if (asked.intent.kind == Kind::write) {
      ++writes;
      longest_write = std::max(longest_write, asked.answered - asked.given);
      refused_writes += asked.answer[0] >= 0x80 && asked.answer[1] == kRefused ? 1U : 0U;
    }
    if (asked.intent.kind == Kind::stop && asked.answer[0] < 0x80) {
      longest_without_stop = std::max(longest_without_stop, world_.now() - last_stop_);
      last_stop_ = world_.now();
    }
  }
  // Idle since the silence behind what was heard or sent last, or since there was something to do.
  void sent(Id id) override {
    const Sent& sent = world_.ledger().sent[id];
    const LineBook& line = world_.ledger().lines[sent.bus];
    Instant since = line.heard + WireTimes(world_.plan().bus(sent.bus).line).silence();
    Instant waits = kNever;
    for (const auto& [other, at] : open_) {
      waits = std::min(waits, at);
    }
    since = std::max({since, waits, line.opened});
    longest_idle = std::max(longest_idle, sent.begin - since);
  }
  /// What is measured begins now.
  void begin() {
    std::ranges::fill(back_, kNever);
    good.clear();
    writes = refused_writes = 0;
    longest_write = longest_idle = longest_without_stop = Duration{0};
  }
  [[nodiscard]] Instant all_back() const { return std::ranges::max(back_); }
  [[nodiscard]] Duration without_stop() const {
    return std::max(longest_without_stop, world_.now() - last_stop_);
  }

  std::map<unsigned, unsigned> good;  ///< by host
  unsigned writes = 0;
  unsigned refused_writes = 0;
  Duration longest_write{0};
  Duration longest_idle{0};
  Duration longest_without_stop{0};

 private:
  static constexpr std::uint8_t kRefused = 0x06;

  World& world_;
  std::vector<Instant> back_;  ///< by station
  std::map<Id, Instant> open_;
  Instant last_stop_ = Instant::min() + std::chrono::hours(1);
};

}  // namespace mbgate::judge

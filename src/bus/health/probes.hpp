// SPDX-License-Identifier: Apache-2.0
// Which requests to devices that are offline may go, and when: one at a time to each, and all of a
// bus together no more than their share of its time while somebody else asks. An idle bus probes
// freely.
#pragma once

#include "bus/health/device_table.hpp"
#include "bus/settings.hpp"
#include "bus/state_reader.hpp"
#include "bus/transmission/transmission.hpp"

namespace mbgate::bus {

class Probes {
 public:
  /// Both outlive it and are those in force.
  Probes(const BusSettings& settings, DeviceTable& devices)
      : settings_(settings), devices_(devices) {}

  /// May the request to an offline device wait for its turn now? Whatever else holds its device
  /// back is not asked.
  [[nodiscard]] bool may_ask(const Job& job, Instant now) const;
  /// The bus has the job. False if it is no probe: somebody else asks.
  bool note_accepted(Job& job, Instant now);
  /// The bus has it no more.
  void note_released(Job& job, Instant at);
  /// If it is a probe: it was left unanswered, or its answer was damaged or cut off.
  void note_unanswered(const Transmission& probe, Instant now);
  /// Are there some that may wait only because nobody else asks?
  [[nodiscard]] bool any_free() const { return free_ > 0; }

 private:
  friend struct mbgate::StateReader;
  [[nodiscard]] bool nobody_else_asks(Instant now) const {
    return others_ == 0 && now >= others_gone_at_ + settings_.timing.probe_interval;
  }

  const BusSettings& settings_;
  DeviceTable& devices_;
  Instant next_at_ = Instant::min();  // of all devices, while somebody else asks
  std::size_t others_ = 0;            // jobs that are here and no probes
  std::size_t free_ = 0;              // probes that are here because nobody else asks
  Instant others_gone_at_ = Instant::min();
};

}  // namespace mbgate::bus

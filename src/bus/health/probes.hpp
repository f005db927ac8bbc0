// SPDX-License-Identifier: Apache-2.0
// Which requests to offline devices may be sent as probes, and when. Each device gets one at a
// time. While there are requests to other devices, all probes of a bus together take at most
// `probe_share` of its time. Otherwise the bus probes freely.
#pragma once

#include "bus/health/device_table.hpp"
#include "bus/settings.hpp"
#include "bus/transmission/transmission.hpp"

namespace mbgate::bus {

class Probes {
 public:
  /// Both must outlive this object and always be those in force.
  Probes(const BusSettings& settings, DeviceTable& devices)
      : settings_(settings), devices_(devices) {}

  /// May this request to an offline device be its probe now? Whatever else holds its device back is
  /// not considered.
  [[nodiscard]] bool may_ask(const Job& job, Instant now) const;
  /// The bus has accepted the job, which is a probe or an ordinary request.
  void note_accepted(Job& job);
  /// The bus no longer has the job.
  void note_released(const Job& job, Instant at);
  /// If the transmission is a probe: it was left unanswered, or its answer was damaged or cut off.
  void note_unanswered(const Job& probe, Instant now);
  /// The next probes of all offline devices are due now.
  void expect_others(Instant now);

 private:
  const BusSettings& settings_;
  DeviceTable& devices_;
  Instant next_at_ = Instant::min();  // of all devices, while there are ordinary requests
  std::size_t others_ = 0;            // jobs of this bus that are not probes
  Instant others_gone_at_ = Instant::min();
};

}  // namespace mbgate::bus

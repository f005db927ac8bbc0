// SPDX-License-Identifier: Apache-2.0
// Limits the journal's lines about each kind of act of a client to so many a minute for each
// client, whatever other clients do. It counts the lines left out. Bounded.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "bus/instant.hpp"
#include "gateway/client.hpp"
#include "gateway/event.hpp"
#include "gateway/limits.hpp"
#include "gateway/settings/settings_snapshot.hpp"
#include "gateway/writes/write_rules.hpp"

namespace mbgate::gateway {

class ReportLimit {
 public:
  explicit ReportLimit(unsigned per_minute) : per_minute_(per_minute) {}

  /// The client has done it once more. Nothing if that is not to be reported; else how often it was
  /// left out since the last report of this client.
  [[nodiscard]] std::optional<std::uint64_t> note(const ClientInfo& client, bus::Instant now);

 private:
  struct Minute {
    bus::Instant began = bus::Instant::min();
    unsigned reports = 0;
    std::uint64_t left_out = 0;
    [[nodiscard]] bool is_over(bus::Instant now) const {
      return reports == 0 || now - began >= kReportedEvery;
    }
  };
  using Client = std::pair<routing::ClientAddress, std::string>;  // with its certificate
  /// That of the client, or the one that those share for whom there is no place.
  [[nodiscard]] Minute& minute_of(Client client, bus::Instant now);

  unsigned per_minute_;
  std::map<Client, Minute> minutes_;
  Minute of_others_;
};

// Which denied requests the journal is told of, and what it is told. Reads, writes and stops are
// counted apart, so that none of them hides another.

class DenialReports {
 public:
  /// The request was denied. Nothing if that is not to be reported.
  [[nodiscard]] std::optional<Event> note(const SettingsSnapshot& settings, const WriteRules& rules,
                                          const ClientInfo& client, const modbus::MbapAdu& request,
                                          Instant now);

 private:
  ReportLimit reads_{kDenialsReported};
  ReportLimit writes_{kDenialsReported};
  ReportLimit stops_{kActsReported};
};

}  // namespace mbgate::gateway

// SPDX-License-Identifier: Apache-2.0
// Decides device by device which requests are stops, and which writes must not be carried out:
// writes that a stop forbids, and writes of a client that may not write to the device now.
//
// To change
// - writer: writers.
// - when failsafe writes are due, and which client counts: failsafe_writes; which requests count as
//   requests to a device, and which as writes: gateway/clients/requests.
#pragma once

#include <optional>

#include "gateway/settings/settings_snapshot.hpp"
#include "gateway/writes/stop_marks.hpp"
#include "gateway/writes/writers.hpp"

namespace mbgate::gateway {

/// Where a write comes from.
struct WriteOrigin {
  ClientId client;
  const ClientInfo& info;
  const ClientKey& key;
  Instant arrival;
};

class WriteRules {
 public:
  explicit WriteRules(const SettingsSnapshot& settings);

  /// A plan of several writes is a stop if each of them is; a broadcast if it is one for any
  /// device.
  [[nodiscard]] bool is_stop(const routing::Plan& plan) const;

  /// Why the write may not reach one of its devices: 01 if it never may, 06 if it may not now.
  /// Nothing if it may.
  [[nodiscard]] std::optional<modbus::ExceptionCode> objection(const routing::Plan& write,
                                                               const WriteOrigin& origin,
                                                               Instant now) const;
  /// Does the `writer` of one of its devices not let this client write, or not now?
  [[nodiscard]] bool is_denied_by_writer(const routing::Plan& write, const WriteOrigin& origin,
                                         Instant now) const;

  /// The request was accepted. Returns its number.
  std::uint64_t note_accepted(const routing::Plan& request, const WriteOrigin& origin, Instant now);
  /// Was a device that the write reaches stopped after the write was accepted, with this number?
  [[nodiscard]] bool was_stopped(const routing::Plan& write, std::uint64_t sequence) const;
  /// The gateway itself stops the device.
  void note_own_stop(std::size_t device, Instant now);
  /// New settings: what is known of removed devices is dropped.
  void adopt(const SettingsSnapshot& settings);

 private:
  [[nodiscard]] bool is_stop(const routing::PlannedTransaction& transaction) const;
  [[nodiscard]] std::optional<modbus::ExceptionCode> objection(
      const routing::PlannedTransaction& write, const WriteOrigin& origin, Instant now) const;

  const SettingsSnapshot* settings_;
  StopMarks stop_marks_;
  Writers writers_;
  std::uint64_t sequence_ = 0;  // of requests that were accepted, and stops of the gateway's own
};

}  // namespace mbgate::gateway

// SPDX-License-Identifier: Apache-2.0
// What a stop is, and which writes must not be carried out: those that a stop forbids, and those of
// a client that may not write to the device now. Decided bus by bus and device by device.
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
  std::uint64_t position;  ///< in the client's stream
  Instant arrival;
};

class WriteRules {
 public:
  explicit WriteRules(const SettingsSnapshot& settings);

  /// A plan of several writes is a stop if each of them is; a broadcast if it is one for any
  /// device.
  [[nodiscard]] bool is_stop(const routing::Plan& plan) const;
  /// The devices whose earlier writes are cancelled by the stop.
  [[nodiscard]] DevicePlaces overtaken_by(const routing::Plan& stop) const;
  /// Of the devices that the write reaches, those whose stops let it go first (`stop_cancels =
  /// false`).
  [[nodiscard]] DevicePlaces goes_before_stops_of(const routing::Plan& write) const;

  /// Why the write may not reach one of its devices: 01 if it never may, 06 if it may not now.
  /// Nothing if it may.
  [[nodiscard]] std::optional<modbus::ExceptionCode> objection(const routing::Plan& write,
                                                               const WriteOrigin& origin,
                                                               Instant now) const;
  /// Does the `writer` of one of its devices not let this client write, or not now?
  [[nodiscard]] bool is_denied_by_writer(const routing::Plan& write, const WriteOrigin& origin,
                                         Instant now) const;
  /// Of a broadcast that is a stop on some buses only: the other buses, on which it is an ordinary
  /// write, if that write may not be sent. Either objection() forbids it there, or the client may
  /// not write (`may_write` is false).
  [[nodiscard]] BusList left_out_of(const routing::Plan& stop, const WriteOrigin& origin,
                                    bool may_write, Instant now) const;

  /// The request was accepted, except for its parts on the buses `left_out`.
  void note_accepted(const routing::Plan& request, const BusList& left_out,
                     const WriteOrigin& origin, Instant now);
  /// A stop of the client was accepted although earlier requests of its stream still wait.
  void note_early(const routing::Plan& stop, const WriteOrigin& origin);
  /// The gateway itself stops the device.
  void note_own_stop(std::size_t device, Instant now);
  void client_gone(ClientId client) { stop_marks_.client_gone(client); }
  /// New settings: what is known of removed devices is dropped.
  void adopt(const SettingsSnapshot& settings);

 private:
  [[nodiscard]] bool is_stop(const routing::PlannedTransaction& transaction) const;
  /// A broadcast that is a stop may be an ordinary write on some of its buses.
  [[nodiscard]] bool stops_on(BusId bus, const routing::Plan& stop) const;
  [[nodiscard]] std::optional<modbus::ExceptionCode> objection(
      const routing::PlannedTransaction& write, const WriteOrigin& origin, Instant now) const;

  const SettingsSnapshot* settings_;
  StopMarks stop_marks_;
  Writers writers_;
};

}  // namespace mbgate::gateway

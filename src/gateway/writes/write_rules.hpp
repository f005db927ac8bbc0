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
  routing::ClientAddress address;
  std::uint64_t position;  ///< in the client's stream
  Instant arrival;
};

class WriteRules {
 public:
  explicit WriteRules(const SettingsSnapshot& settings);

  /// A run of writes is a stop if each of them is, a broadcast if any device takes it for one.
  [[nodiscard]] bool is_stop(const routing::Plan& plan) const;
  /// The devices to which writes that came before the stop are not transmitted any more.
  [[nodiscard]] DevicePlaces overtaken_by(const routing::Plan& stop) const;
  /// The devices that the write reaches, whose stops let it go first.
  [[nodiscard]] DevicePlaces goes_before_stops_of(const routing::Plan& write) const;

  /// Why the write may not reach one of its devices: 01 if that is so for ever, else 06.
  [[nodiscard]] std::optional<modbus::ExceptionCode> objection(const routing::Plan& write,
                                                               const WriteOrigin& origin,
                                                               Instant now) const;
  /// The buses on which a part of the stop is none and has an objection of its own, or may not go
  /// because its client's writes may not (`may_write`).
  [[nodiscard]] BusList left_out_of(const routing::Plan& stop, const WriteOrigin& origin,
                                    bool may_write, Instant now) const;

  /// The request was accepted, but for the parts on some buses.
  void note_accepted(const routing::Plan& request, const BusList& left_out,
                     const WriteOrigin& origin, Instant now);
  /// A stop of the client that lies there in its stream was accepted before what lies before it.
  void note_early(const routing::Plan& stop, const WriteOrigin& origin);
  /// The gateway itself stops the device.
  void note_own_stop(std::size_t device, Instant now);
  void client_gone(ClientId client) { stop_marks_.client_gone(client); }
  /// Other settings: what is known of a device goes over to its new place.
  void adopt(const SettingsSnapshot& settings);

 private:
  friend struct mbgate::StateReader;
  [[nodiscard]] bool is_stop(const routing::PlannedTransaction& transaction) const;
  /// A broadcast that is a stop may be a write like others on some of its buses.
  [[nodiscard]] bool stops_on(BusId bus, const routing::Plan& stop) const;
  [[nodiscard]] std::optional<modbus::ExceptionCode> objection(
      const routing::PlannedTransaction& write, const WriteOrigin& origin, Instant now) const;

  const SettingsSnapshot* settings_;
  StopMarks stop_marks_;
  Writers writers_;
};

}  // namespace mbgate::gateway

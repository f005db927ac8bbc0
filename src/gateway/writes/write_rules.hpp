// SPDX-License-Identifier: Apache-2.0
// Decides device by device which requests are stops, and which writes must not be carried out:
// writes that a stop forbids, and writes of a client that may not write to the device now.
//
// To change
// - when failsafe writes are due, and which client counts: failsafe_writes; which requests count as
//   requests to a device, and which as writes: gateway/clients/requests.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "drive/device.hpp"
#include "gateway/client.hpp"
#include "gateway/settings.hpp"
#include "gateway/settings/settings_snapshot.hpp"
#include "modbus/pdu.hpp"

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

  /// Why a write may not reach a device.
  struct Objection {
    modbus::ExceptionCode code;  ///< 01 if it never may, 06 if it may not now
    bool by_writer;              ///< the `writer` of the device denies it; else a stop forbids it
  };
  /// Of all devices that the write reaches: what is never allowed rather than what is not allowed
  /// now, and what a `writer` denies rather than what a stop forbids. Nothing if it may be sent.
  [[nodiscard]] std::optional<Objection> objection(const routing::Plan& write,
                                                   const WriteOrigin& origin, Instant now) const;

  /// The request was accepted. Returns its number.
  std::uint64_t note_accepted(const routing::Plan& request, const WriteOrigin& origin, Instant now);
  /// Was a device that the write reaches stopped after the write was accepted, with this number?
  [[nodiscard]] bool was_stopped(const routing::Plan& write, std::uint64_t sequence) const;
  /// The gateway itself stops the device.
  void note_own_stop(std::size_t device, Instant now);
  /// New settings, while those before are still there. What is known of a device stays with it,
  /// under another name too; that of removed ones is dropped.
  void adopt(const SettingsSnapshot& settings);

 private:
  /// What is known of a device. A write that arrived before a stop, wherever it was held meanwhile,
  /// must not be sent after it.
  struct Known {
    Instant stopped_at = Instant::min();
    std::optional<ClientId> stopped_by{};  ///< nothing: the gateway itself
    Instant others_at = Instant::min();    ///< the last stop before that of any other client
    std::uint64_t stop = 0;                ///< its number among the requests
    ClientKey writer{};                    ///< that wrote last
    Instant wrote_at = Instant::min();
  };
  [[nodiscard]] std::optional<Objection> objection(std::size_t device, const WriteOrigin& origin,
                                                   Instant now) const;
  void note_stop(Known& known, std::optional<ClientId> client, Instant now) const;

  const SettingsSnapshot* settings_;
  std::vector<Known> known_;    // by device
  std::uint64_t sequence_ = 0;  // of requests that were accepted, and stops of the gateway's own
};

}  // namespace mbgate::gateway

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

// The writes that the accepted stops forbid, device by device: a write that arrived before a stop,
// wherever it was held meanwhile, must not be sent after it.

class StopMarks {
 public:
  explicit StopMarks(std::size_t devices) : marks_(devices) {}

  /// A stop for the device was accepted from this client, as the gateway's request number
  /// `sequence`; from none, if it is the gateway's own.
  void note(std::size_t device, std::optional<ClientId> client, std::uint64_t sequence,
            Instant now) {
    Mark& mark = marks_[device];
    if (mark.client != client) {
      mark.others_at = mark.at;
      mark.client = client;
    }
    mark.at = now;
    mark.sequence = sequence;
  }
  /// Does a stop of another client forbid a write to the device that arrived at `arrival`? What
  /// lies in a client's stream behind its own stop comes after it.
  [[nodiscard]] bool forbids(std::size_t device, ClientId client, Instant arrival) const {
    const Mark& mark = marks_[device];
    return arrival < (mark.client == client ? mark.others_at : mark.at);
  }
  /// Was a stop for the device accepted after request number `sequence`?
  [[nodiscard]] bool came_after(std::size_t device, std::uint64_t sequence) const {
    return sequence < marks_[device].sequence;
  }
  /// Other settings: nothing is known of what is gone.
  void adopt(const std::vector<drive::Device>& devices) {
    marks_.resize(devices.size());
    for (std::size_t device = 0; device < devices.size(); ++device) {
      if (devices[device].is_gone()) {
        marks_[device] = {};
      }
    }
  }

 private:
  struct Mark {
    Instant at = Instant::min();
    std::optional<ClientId> client;      ///< whose stop that was
    Instant others_at = Instant::min();  ///< the last stop before that of any other client
    std::uint64_t sequence = 0;
  };
  std::vector<Mark> marks_;
};

// The clients that may write to a device, if its guard is narrower than the access rights.

class Writers {
 public:
  explicit Writers(std::size_t devices) : owners_(devices) {}

  /// Why the client may not write to the device: 01 if it never may, 06 while another client owns
  /// writing. Nothing if it may.
  [[nodiscard]] std::optional<modbus::ExceptionCode> objection(std::size_t device,
                                                               const DeviceGuard& guard,
                                                               const ClientInfo& client,
                                                               const ClientKey& key,
                                                               bus::Instant now) const;
  /// A write of the client to the device was accepted.
  void note(std::size_t device, const ClientKey& client, bus::Instant now) {
    owners_[device] = Owner{client, now};
  }
  /// Other settings: nobody owns what is gone.
  void adopt(const std::vector<drive::Device>& devices) {
    owners_.resize(devices.size());
    for (std::size_t device = 0; device < devices.size(); ++device) {
      if (devices[device].is_gone()) {
        owners_[device].reset();
      }
    }
  }

 private:
  struct Owner {
    ClientKey client;
    bus::Instant wrote;
  };
  std::vector<std::optional<Owner>> owners_;
};

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

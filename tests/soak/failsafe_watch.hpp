// SPDX-License-Identifier: Apache-2.0
// Failsafe writes, seen from outside: they are not sent while the client that wrote last to the
// device is there and asks it something, and they are done when nobody is left.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "soak/asked.hpp"
#include "soak/flight.hpp"

namespace mbgate::soak {

/// Nobody else writes these values.
bool is_failsafe(const PduBytes& pdu);

class FailsafeWatch {
 public:
  explicit FailsafeWatch(const SoakPlan& plan)
      : plan_(plan), devices_(plan.settings.devices.size()) {}

  /// The gateway has taken what a client asks of the device.
  void asked(std::size_t device, const Asked& asked, Instant now);
  /// What the client has written to the device was done.
  void wrote(std::size_t device, ClientId client, Instant now);
  /// Somebody has written to all, or who may write has become another one.
  void forget_writers();
  void gone(ClientId client);
  /// The device has carried out what is no stop; or one of its own failsafe writes.
  void written(std::size_t device, Instant now) { devices_[device].written = now; }
  void done(std::size_t device, const PduBytes& pdu, Instant now) {
    devices_[device].done[pdu] = now;
  }
  /// One is sent to the device. Must it not be?
  [[nodiscard]] bool is_unwanted(std::size_t device, Instant now) const;
  /// Nobody has been there for long: what was not done for the device.
  [[nodiscard]] std::optional<PduBytes> missing(std::size_t device, Instant since) const;

 private:
  struct Device {
    std::optional<ClientId> writer;  ///< the last one, while it is connected
    Instant asked = Instant::min();  ///< by that one
    Instant written = Instant::min();
    std::map<PduBytes, Instant> done;
  };

  const SoakPlan& plan_;
  std::vector<Device> devices_;
};

}  // namespace mbgate::soak

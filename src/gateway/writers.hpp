// SPDX-License-Identifier: Apache-2.0
// Who may write to a device, where its guard says more than the access rights do.
#pragma once

#include <optional>
#include <vector>

#include "gateway/device_guard.hpp"
#include "gateway/settings_diff.hpp"
#include "modbus/pdu.hpp"

namespace mbgate::gateway {

class Writers {
 public:
  explicit Writers(std::size_t devices) : owners_(devices) {}

  /// Why the client may not write to the device: 01 if it never may, 06 while another one owns
  /// writing. Nothing if it may.
  [[nodiscard]] std::optional<modbus::ExceptionCode> objection(std::size_t device,
                                                               const DeviceGuard& guard,
                                                               const routing::ClientAddress& client,
                                                               bus::Instant now) const;
  /// A write of the client to the device was accepted.
  void note(std::size_t device, const routing::ClientAddress& client, bus::Instant now) {
    owners_[device] = Owner{client, now};
  }
  /// Other settings: the owner of a device goes over to its new place.
  void renumber(const SettingsDiff& diff, std::size_t devices) {
    diff.move_devices(owners_, devices);
  }

 private:
  struct Owner {
    routing::ClientAddress client;
    bus::Instant wrote;
  };
  std::vector<std::optional<Owner>> owners_;
};

}  // namespace mbgate::gateway

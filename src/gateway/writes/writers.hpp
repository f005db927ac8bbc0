// SPDX-License-Identifier: Apache-2.0
// The clients that may write to a device, if its guard is narrower than the access rights.
#pragma once

#include <optional>
#include <vector>

#include "gateway/client.hpp"
#include "gateway/device_guard.hpp"
#include "gateway/settings.hpp"
#include "modbus/pdu.hpp"

namespace mbgate::gateway {

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

}  // namespace mbgate::gateway

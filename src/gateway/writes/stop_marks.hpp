// SPDX-License-Identifier: Apache-2.0
// Which writes are forbidden by the stops that were accepted, device by device: a write that
// arrived before a stop, wherever it was held meanwhile, must not be sent after it.
#pragma once

#include <algorithm>
#include <optional>
#include <unordered_map>
#include <vector>

#include "drive/device.hpp"
#include "gateway/client.hpp"

namespace mbgate::gateway {

class StopMarks {
 public:
  explicit StopMarks(std::size_t devices) : marks_(devices) {}

  /// A stop for the device was taken from this client; from none, if it is the gateway's own.
  void note(std::size_t device, std::optional<ClientId> client, Instant now) {
    Mark& mark = marks_[device];
    if (mark.client != client) {
      mark.others_at = mark.at;
      mark.client = client;
    }
    mark.at = now;
  }
  /// A stop was taken from the client although earlier requests of its stream still wait.
  void note_early(std::size_t device, ClientId client, std::uint64_t position) {
    std::vector<Place>& places = early_[client];
    const auto known = std::ranges::find(places, device, &Place::device);
    if (known != places.end()) {
      known->position = std::max(known->position, position);
    } else {
      places.push_back({device, position});
    }
  }
  /// Does a stop forbid a write to the device that arrived at `arrival` and is at `position` in its
  /// client's stream? Times are compared only with the stops of others: the client's own write
  /// behind its stop may have arrived at the same instant.
  [[nodiscard]] bool forbids(std::size_t device, ClientId client, std::uint64_t position,
                             Instant arrival) const {
    const Mark& mark = marks_[device];
    return arrival < (mark.client == client ? mark.others_at : mark.at) ||
           lies_before_early(device, client, position);
  }
  void client_gone(ClientId client) { early_.erase(client); }
  /// Other settings: nothing is known of what is gone.
  void adopt(const std::vector<drive::Device>& devices);

 private:
  struct Mark {
    Instant at = Instant::min();
    std::optional<ClientId> client;      ///< whose stop that was
    Instant others_at = Instant::min();  ///< the last stop before that of any other client
  };
  struct Place {
    std::size_t device;
    std::uint64_t position;
  };
  [[nodiscard]] bool lies_before_early(std::size_t device, ClientId client,
                                       std::uint64_t position) const {
    const auto places = early_.find(client);
    return places != early_.end() && std::ranges::any_of(places->second, [&](const Place& it) {
             return it.device == device && position < it.position;
           });
  }

  std::vector<Mark> marks_;
  std::unordered_map<ClientId, std::vector<Place>> early_;
};

inline void StopMarks::adopt(const std::vector<drive::Device>& devices) {
  marks_.resize(devices.size());
  for (std::size_t device = 0; device < devices.size(); ++device) {
    if (devices[device].is_gone()) {
      marks_[device] = {};
    }
  }
  for (auto& [client, places] : early_) {
    std::erase_if(places, [&](const Place& it) { return devices[it.device].is_gone(); });
  }
}

}  // namespace mbgate::gateway

// SPDX-License-Identifier: Apache-2.0
// When the failsafe writes of a device are due: the last client that may write to it has gone, or
// all of them are silent. Once until one of them asks again or another one comes: nobody could have
// set the device going since.
#pragma once

#include <map>
#include <optional>
#include <unordered_map>
#include <vector>

#include "gateway/device_index.hpp"
#include "gateway/event.hpp"

namespace mbgate::gateway {

class Failsafe {
 public:
  struct Due {
    std::size_t device;
    bool silence;  ///< the clients are there, but silent
  };

  /// Watches a device. A `quiet` of 0: silence is no reason.
  void watch(std::size_t device, Duration quiet) { watches_[device].quiet = quiet; }

  /// The client may write to these devices, which are watched.
  void client_came(ClientId client, const DevicePlaces& devices, Instant now);
  /// Any request counts.
  void client_asked(ClientId client, Instant now);
  /// Does it wait for an answer of ours? Then it is not silent; when it has them all, its silence
  /// begins.
  void client_waits(ClientId client, bool waits, Instant now);
  void client_gone(ClientId client);

  /// The next device whose time has come.
  std::optional<Due> take_due(Instant now);
  /// When take_due() may have something to say, at the latest; nothing before that.
  [[nodiscard]] std::optional<Instant> next() const;
  /// Other settings: what was seen of a device in `old` goes over to its new place. To be called
  /// once the clients that may write there now have come.
  void carry(std::size_t device, const Failsafe& old, std::size_t old_device);

 private:
  struct Watch {
    Duration quiet{0};
    std::size_t clients = 0;
    std::size_t waiting = 0;          ///< of these, those that wait for an answer
    Instant active = Instant::min();  ///< when one of them asked or was answered last, or came
    bool sent = false;                ///< since then
  };
  struct Client {
    DevicePlaces devices;
    bool waits = false;
  };
  void note_activity(Watch& watch, Instant now);
  [[nodiscard]] static std::optional<Instant> silent_at(const Watch& watch);

  std::map<std::size_t, Watch> watches_;
  std::unordered_map<ClientId, Client> clients_;
  std::vector<Due> due_;
  /// No watch is silent earlier; found anew when it comes, because most of what happens only makes
  /// it later.
  std::optional<Instant> earliest_silence_;
};

}  // namespace mbgate::gateway

// SPDX-License-Identifier: Apache-2.0
// When the failsafe writes of a device are due: the last client that may write to it has gone, or
// all of them are silent. Once until one of them asks again: nobody could have set the device going
// since. A connection that never asked anything is no such client: it keeps nothing back and sets
// nothing off. What is due and could not be transmitted stays due as long as nobody asks.
#pragma once

#include <map>
#include <optional>
#include <unordered_map>
#include <vector>

#include "gateway/client.hpp"
#include "gateway/event.hpp"
#include "gateway/settings/device_index.hpp"

namespace mbgate::gateway {

class Failsafe {
 public:
  struct Due {
    std::size_t device;
    FailsafeReason reason;
    std::vector<std::size_t> sent{};  ///< the places of the writes that were transmitted already
    bool told = false;                ///< that they could not be sent yet
  };

  /// Watches a device. A `quiet` of 0: silence is no reason.
  void watch(std::size_t device, Duration quiet) { watches_[device].quiet = quiet; }

  /// The client may write to these devices, which are watched. It counts once it has asked.
  void client_came(ClientId client, const DevicePlaces& devices);
  /// Any request counts. Returns the devices whose writes were said not to be sent yet, and are not
  /// due any more.
  DevicePlaces client_asked(ClientId client, Instant now);
  /// Does it wait for an answer of ours? Then it is not silent; when it has them all, its silence
  /// begins.
  void client_waits(ClientId client, bool waits, Instant now);
  [[nodiscard]] bool does_wait(ClientId client) const;
  void client_gone(ClientId client);

  /// The next device whose time has come.
  std::optional<Due> take_due(Instant now);
  /// Some of its writes could not be transmitted: it is due again soon, or when its line is back.
  /// False: not any more, because a client has asked since.
  bool put_back(Due due);
  void line_is_back(std::size_t device);
  /// The gateway stops, or the device goes: the device, if it is due, or if somebody may have set
  /// it going since, for this reason.
  std::optional<Due> take_last(std::size_t device, FailsafeReason reason);
  /// When take_due() may have something to say, at the latest; nothing before that.
  [[nodiscard]] std::optional<Instant> next() const;
  /// Other settings: what was seen of the device in `old` holds. To be called once the clients that
  /// may write there now have come. `same_writes`: what was transmitted of them counts.
  void carry(std::size_t device, const Failsafe& old, bool same_writes);

 private:
  struct Watch {
    Duration quiet{0};
    std::size_t clients = 0;
    std::size_t waiting = 0;          ///< of these, those that wait for an answer
    Instant active = Instant::min();  ///< when one of them asked or was answered last
    bool armed = false;               ///< one of them has asked since they were due
    std::optional<Due> pending{};     ///< and not taken
    std::optional<Instant> again_at;  ///< it is tried again then
  };
  struct Client {
    DevicePlaces devices;
    bool has_asked = false;
    bool waits = false;
  };
  void note_activity(Watch& watch, Instant now);
  void set_due(std::size_t device, Watch& watch, FailsafeReason reason);
  void look_at_times(Instant now);
  [[nodiscard]] static std::optional<Instant> silent_at(const Watch& watch);

  std::map<std::size_t, Watch> watches_;
  std::unordered_map<ClientId, Client> clients_;
  std::vector<std::size_t> due_;       // to be taken
  std::vector<std::size_t> returned_;  // put back since take_due() was called last
  /// No watch is silent, or to be tried again, earlier; found anew when it comes, because most of
  /// what happens only makes it later.
  std::optional<Instant> earliest_;
};

}  // namespace mbgate::gateway

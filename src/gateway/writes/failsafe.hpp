// SPDX-License-Identifier: Apache-2.0
// When the failsafe writes of a device are due: the last client that may write to it has
// disconnected, or all of these clients are silent. They are due once, and again only after such a
// client has sent a request: until then no client can have set the device in motion. A connection
// that never sent a request is no such client: it neither prevents nor triggers them. Writes that
// are due and could not be transmitted stay due until such a client sends a request.
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
    bool told = false;                ///< it was reported that they could not be sent yet
  };

  /// Watches a device. A `quiet` of 0: silence is no reason.
  void watch(std::size_t device, Duration quiet) { watches_[device].quiet = quiet; }

  /// The client may write to these devices, which are watched. It counts once it has sent a
  /// request.
  void client_came(ClientId client, const DevicePlaces& devices);
  /// The client has sent a whole request, of any kind. Returns the devices whose writes were
  /// reported as not yet sent and are now no longer due.
  DevicePlaces client_asked(ClientId client, Instant now);
  /// `waits`: the client waits for an answer, or for its turn. Then it is not silent. Its silence
  /// begins when it has all its answers.
  void client_waits(ClientId client, bool waits, Instant now);
  void client_gone(ClientId client);

  /// The next device whose failsafe writes are due; nothing if there is none.
  std::optional<Due> take_due(Instant now);
  /// Some of its writes could not be transmitted: it is due again soon, or when its line is back.
  /// False: it is no longer due, because a client has sent a request since.
  bool put_back(Due due);
  void line_is_back(std::size_t device);
  /// The gateway stops, or the device leaves the configuration. Returns the device if it is due, or
  /// for this reason if a client may have set it in motion since.
  std::optional<Due> take_last(std::size_t device, FailsafeReason reason);
  /// When take_due() may have something to say, at the latest; nothing before that.
  [[nodiscard]] std::optional<Instant> next() const;
  /// New settings: takes over what `old` knows of the device. To be called after client_came() for
  /// all clients that may write to it now. `same_writes`: the writes are the same, so those already
  /// transmitted count.
  void carry(std::size_t device, const Failsafe& old, bool same_writes);

 private:
  struct Watch {
    Duration quiet{0};
    std::size_t clients = 0;
    std::size_t waiting = 0;          ///< of these, those that wait for an answer
    Instant active = Instant::min();  ///< when one of them asked or was answered last
    bool armed = false;               ///< one of them has sent a request since they were due
    std::optional<Due> pending{};     ///< due, and not taken
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
  /// No watch becomes silent, or is to be tried again, before this. It is found anew when it comes,
  /// because most events only make it later.
  std::optional<Instant> earliest_;
};

}  // namespace mbgate::gateway

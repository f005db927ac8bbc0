// SPDX-License-Identifier: Apache-2.0
// When the failsafe writes of a device are due, seen from outside: the last client that may write
// to it has gone, or all of them were silent for so long.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "soak/asked.hpp"

namespace mbgate::soak {

class FailsafeWatch {
 public:
  explicit FailsafeWatch(const SoakPlan& plan);

  /// A connection is no client until it asks something.
  void came(ClientId client, std::size_t listener, unsigned host);
  /// The devices to which it may write, and which are watched.
  std::vector<std::size_t> asked(ClientId client, Instant now);
  /// Does it wait for an answer? Then it is not silent.
  void waits(ClientId client, bool waits, Instant now);
  void gone(ClientId client);
  /// What has become due, as requests of a client that is gone; each is given once.
  std::vector<Asked> take_due(Instant now);
  /// Is there nothing of it that is due, or under way? Then other writes may be set.
  [[nodiscard]] bool is_armed(std::size_t device) const;
  /// By the settings in force, and from then on what has been read and has its turn by these: it
  /// comes before what is due.
  void after_reload();
  /// All of that was taken.
  void after_turns() { takes_turns_ = false; }
  /// What is sent because the gateway stops.
  std::vector<Asked> take_at_exit(Instant now);

 private:
  struct Watch {
    Door door;
    std::vector<bool> listeners;  ///< that lead to the device with write access
    std::vector<unsigned> hosts;
    bool is_listed = false;
    std::size_t clients = 0;
    std::size_t waiting = 0;  ///< of these, for an answer
    Instant active;
    bool sent = true;  ///< since then; nobody has asked yet
    bool due = false;
  };

  struct Client {
    std::size_t listener = 0;
    unsigned host = 0;
    std::vector<std::size_t> watches{};
    bool has_asked = false;
    bool waits = false;
  };

  [[nodiscard]] std::vector<std::size_t> watches_of(std::size_t listener, unsigned host) const;
  void note_activity(Watch& watch, Instant now);
  void add_writes(std::vector<Asked>& due, const Watch& watch, Instant now) const;
  [[nodiscard]] Duration quiet_of(const Watch& watch) const {
    return plan_.settings.guards[*watch.door.device].quiet;
  }
  /// When it is silent, as far as is known.
  [[nodiscard]] std::optional<Instant> silent_at(const Watch& watch) const;
  [[nodiscard]] std::uint8_t address_of(const Watch& watch) const {
    return plan_.settings.devices[*watch.door.device].address;
  }

  const SoakPlan& plan_;
  std::vector<Watch> watches_;
  std::map<ClientId, Client> clients_;
  Instant next_ = Instant::max();  ///< nothing is due before
  bool takes_turns_ = false;       ///< of what waited for a reload
};

}  // namespace mbgate::soak

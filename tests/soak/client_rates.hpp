// SPDX-License-Identifier: Apache-2.0
// How often one host may connect to a listener and ask there, as far as it can be told from
// outside: so many at once as the limit says, then one after the other. More connections are
// refused; more requests wait for their turn, and none for longer.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "soak/asked.hpp"

namespace mbgate::soak {

class ClientRates {
 public:
  explicit ClientRates(const SoakPlan& plan);

  /// Must one that comes now be let in, as far as this goes? Nothing: after a reload nobody can
  /// tell.
  [[nodiscard]] std::optional<bool> lets_in(std::size_t listener, unsigned host, Instant now) const;
  void let_in(std::size_t listener, unsigned host, Instant now);
  void came(ClientId client, std::size_t listener, unsigned host);

  /// The gateway has the first byte of the request.
  void begun(Asked& asked, Instant now);
  /// It has the request, and room for it. Notes whether it may be held up, and until when.
  void accepted(Asked& asked, Instant now);
  /// A stop was taken ahead of others, with a place of the pipeline.
  void went_ahead(const Asked& stop);
  /// Its host has waited for its turn since then, if the gateway holds it up.
  [[nodiscard]] Instant waits_since(const Asked& asked) const;
  /// The gateway may not have taken it yet: it holds it up, or others before it.
  [[nodiscard]] static bool may_hold(const Asked& asked, Duration lateness, Instant now);
  /// Nothing is held up any more by this limit, where there is none now.
  void lifted(Asked& asked, Instant now) const;
  /// Its answer comes. What is wrong with that; nothing if nothing is.
  [[nodiscard]] std::string answered(const Asked& asked, Duration lateness, Instant now);
  /// Its host may ask so often only, and it may be its turn by now.
  [[nodiscard]] bool may_have_its_turn(const Asked& asked, Instant now);
  /// The gateway may hold up a request of its host, or may have done so until this instant.
  [[nodiscard]] bool may_have_held(ClientId client, Instant now) const;
  void closed(const Asked& asked, Instant now);
  void after_reload(Instant now);

 private:
  using Key = std::pair<std::size_t, unsigned>;  // listener and host
  struct Bucket {
    // Of connections: each takes a part of a second, as they are counted since ever, and since the
    // limit became what it is.
    Instant connected_until = Instant::min();
    Instant connected_anew = Instant::min();
    // Of requests: at the latest, while they come from one connection only.
    Instant counted_until = Instant::min();
    Instant taken_until = Instant::min();
    Instant answered = Instant::min();  ///< the last one
    std::size_t open = 0;
    std::optional<ClientId> only;
    bool is_shared = false;          ///< nobody can tell when they are taken
    bool was_changed = false;        ///< meanwhile: what is given back may be less than was taken
    Instant since = Instant::min();  ///< what came before may have been taken by another limit
    std::uint64_t order = 0;         ///< it changes when what was known of that is not so any more
    Instant stopped = Instant::max();  ///< when the first stop began to come, of those meanwhile
    std::vector<Instant> let_through;  ///< when those that were surely taken began to come
  };
  struct Limits {
    unsigned connects = 0;
    unsigned requests = 0;
    std::size_t pipeline = 0;
    friend bool operator==(const Limits&, const Limits&) = default;
  };
  [[nodiscard]] Limits limits_of(std::size_t listener) const;
  [[nodiscard]] unsigned rate_of(const Asked& asked) const;
  [[nodiscard]] Bucket& bucket_of(const Asked& asked);
  void share(Bucket& bucket);
  [[nodiscard]] static bool is_too_soon(Bucket& bucket, const Asked& asked, unsigned rate,
                                        Instant now);

  const SoakPlan& plan_;
  std::vector<Limits> limits_;  // in force, by listener
  std::map<Key, Bucket> buckets_;
  std::map<ClientId, Key> clients_;
};

}  // namespace mbgate::soak

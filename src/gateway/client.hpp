// SPDX-License-Identifier: Apache-2.0
// Data that accompany a client's requests everywhere: the client's connection, its turns on a bus,
// and the place of each answer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "bus/job.hpp"
#include "gateway/settings.hpp"
#include "routing/client_address.hpp"

namespace mbgate::gateway {

/// A TCP connection; the driver numbers them and uses no number twice.
enum class ClientId : std::uint64_t {};

/// What the shell knows of a client when it connects.
struct ClientInfo {
  ListenerId listener{};
  routing::ClientAddress address;
  /// What can be read from it already may have waited since then; Instant::min(): through a start.
  /// Nothing: there is nothing to be read yet.
  std::optional<bus::Instant> waits_since{};
  routing::ClientRole role{};
};

/// What limits and turns count a client by: its address, of IPv6 the first 64 bits; or the name of
/// its certificate, where its listener counts certificates and it has one.
struct ClientKey {
  routing::ClientAddress network{};
  std::string certificate{};
  friend auto operator<=>(const ClientKey&, const ClientKey&) = default;
};
[[nodiscard]] inline ClientKey key_of(const ClientInfo& info, const ListenerSettings& listener) {
  const std::string& name = info.role.certificate;
  return listener.counts_certificates && !name.empty() ? ClientKey{{}, name}
                                                       : ClientKey{info.address.counted_as()};
}

/// The place of an answer among those of its connection.
enum class AnswerId : std::uint64_t {};

/// Which client address takes a turn with a request on a bus, and how many turns it has where
/// others have one.
struct Turns {
  bus::FairnessKey key{};
  unsigned weight = 1;
};

}  // namespace mbgate::gateway

// SPDX-License-Identifier: Apache-2.0
// The identity of a client: its network address. IPv4 is kept in its IPv6-mapped form, so that one
// type serves both and an IPv4 client of an IPv6 socket is the same client.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace mbgate::routing {

class ClientAddress {
 public:
  using Octets = std::array<std::uint8_t, 16>;

  ClientAddress() = default;
  explicit ClientAddress(const Octets& octets) : octets_(octets) {}
  /// "192.168.10.5" or "fe80::1", without zone; nothing if it is neither.
  static std::optional<ClientAddress> parse(std::string_view text);

  [[nodiscard]] const Octets& octets() const { return octets_; }
  [[nodiscard]] bool is_v4() const;
  [[nodiscard]] std::string to_text() const;
  /// What limits and turns are counted by: an IPv4 address as it is; of an IPv6 address the first
  /// 64 bits, because whoever has one has all the others of its network (RFC 4291, 2.5.4).
  [[nodiscard]] ClientAddress counted_as() const;
  friend auto operator<=>(const ClientAddress&, const ClientAddress&) = default;

 private:
  Octets octets_{};
};

/// An address block in CIDR form.
class Network {
 public:
  /// "192.168.10.0/24", "10.0.0.7", "::/0"; nothing if it is no such thing or has bits beyond its
  /// prefix.
  static std::optional<Network> parse(std::string_view text);
  [[nodiscard]] bool contains(const ClientAddress& address) const;
  /// Is it a single address?
  [[nodiscard]] bool is_host() const { return prefix_ == kAddressBits; }
  /// Is every address of the other one in it?
  [[nodiscard]] bool contains(const Network& other) const;
  friend bool operator==(const Network&, const Network&) = default;

 private:
  static constexpr unsigned kAddressBits = 128;
  Network(const ClientAddress& address, unsigned prefix) : address_(address), prefix_(prefix) {}
  ClientAddress address_;
  unsigned prefix_;  ///< of 128 bits
};

using NetworkList = std::vector<Network>;

/// Is the address in one of the networks?
bool contains(const NetworkList& list, const ClientAddress& address);
/// Does a list of those who may connect let the address in? An empty one lets everybody in.
inline bool lets_in(const NetworkList& allow, const ClientAddress& address) {
  return allow.empty() || contains(allow, address);
}

// An address of this machine with a TCP port, as a person writes it: "127.0.0.1:8080",
// "[::1]:8080".

struct ListenAddress {
  ClientAddress address;
  std::uint16_t port = 0;  ///< 0: the kernel chooses
  /// Nothing if it is no address with a port; IPv6, and it alone, stands in brackets.
  static std::optional<ListenAddress> parse(std::string_view text);
  friend bool operator==(const ListenAddress&, const ListenAddress&) = default;
};

/// What only this machine itself reaches (RFC 1122, 3.2.1.3; RFC 4291, 2.5.3).
NetworkList loopback_networks();
bool is_loopback(const ClientAddress& address);

}  // namespace mbgate::routing

// SPDX-License-Identifier: Apache-2.0
// Who a client is: its network address, and the role and the name in its certificate. Lists of
// clients by these.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "modbus/bytes.hpp"

namespace mbgate::routing {

// IPv4 is kept in its IPv6-mapped form, so that one type serves both and an IPv4 client of an IPv6
// socket is the same client.

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
/// Is there an address in both?
bool have_common(const NetworkList& a, const NetworkList& b);
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
/// Does the address mean nothing without an interface (RFC 4291, 2.5.6)?
bool is_link_local(const ClientAddress& address);

// The identity of a client by its certificate: the role in the X.509v3 extension
// 1.3.6.1.4.1.50316.802.1 (MB-TCP-Security v36, 8.3), and the subject's common name.

struct ClientRole {
  enum class Kind : std::uint8_t {
    none,        ///< no TLS: the client has shown no certificate
    named,       ///< what the certificate says; without the extension the NULL role, ""
    unreadable,  ///< the extension is empty, of a wrong type, or there twice: nothing is allowed
  };
  Kind kind = Kind::none;
  std::string name{};
  /// The common name of the certificate's subject (RFC 5280, 4.1.2.6), in UTF-8; empty: it has
  /// none, or there is no certificate.
  std::string certificate{};

  friend bool operator==(const ClientRole&, const ClientRole&) = default;
};

// A list of clients in the configuration: by address, by the role in their certificate, or by its
// name.

struct ClientList {
  ClientList() = default;
  ClientList(std::initializer_list<Network> blocks) : networks(blocks) {}
  ClientList(NetworkList blocks) : networks(std::move(blocks)) {}

  [[nodiscard]] bool empty() const {
    return networks.empty() && roles.empty() && certificates.empty();
  }
  /// Can no more than one client be in it?
  [[nodiscard]] bool names_one() const {
    return roles.empty() && networks.size() + certificates.size() == 1 &&
           (networks.empty() || networks.front().is_host());
  }
  /// Is it the client's address, its role or its certificate? A role that cannot be read is none.
  [[nodiscard]] bool contains(const ClientAddress& address, const ClientRole& role) const;
  friend bool operator==(const ClientList&, const ClientList&) = default;

  NetworkList networks{};
  std::vector<std::string> roles{};         ///< "": the NULL role
  std::vector<std::string> certificates{};  ///< common names
};

// The role in a client's certificate: the extension 1.3.6.1.4.1.50316.802.1, a UTF8String, which is
// the role as a whole (MB-TCP-Security v36, R-21, R-22, R-65). Pure: bytes in, role out.

/// Of the extension, as text.
inline constexpr const char* kRoleExtension = "1.3.6.1.4.1.50316.802.1";

/// In bytes. More is no name that anybody has given; a certificate with it is not understood.
inline constexpr std::size_t kLongestRole = 255;

/// What a certificate says with these values of the extension, each in DER; none: the NULL role
/// . Two roles, an empty one, another type and wrong DER are unreadable.
ClientRole role_of(std::span<const modbus::Bytes> values);

}  // namespace mbgate::routing

// SPDX-License-Identifier: Apache-2.0
// The identity of a client by its certificate: the role in the X.509v3 extension
// 1.3.6.1.4.1.50316.802.1 (MB-TCP-Security v36, 8.3), and the subject's common name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "modbus/bytes.hpp"
#include "routing/client_address.hpp"

namespace mbgate::routing {

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

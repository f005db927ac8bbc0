// SPDX-License-Identifier: Apache-2.0
// The identity of a client by its certificate: the role in the X.509v3 extension
// 1.3.6.1.4.1.50316.802.1 (MB-TCP-Security v36, 8.3), and the subject's common name.
#pragma once

#include <cstdint>
#include <string>

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

}  // namespace mbgate::routing

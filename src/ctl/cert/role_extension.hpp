// SPDX-License-Identifier: Apache-2.0
// The role in a client's certificate: the X.509v3 extension 1.3.6.1.4.1.50316.802.1 of the
// Modbus/TCP Security protocol, whose value is one UTF8String, the whole role.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "ctl/tls/openssl.hpp"

namespace mbgate::ctl {

inline constexpr const char* kRoleExtension = "1.3.6.1.4.1.50316.802.1";
inline constexpr std::size_t kLongestRole = 255;

/// Why a certificate should not have this role, a sentence, or nothing.
std::string wrong_role(const std::string& role);

/// `role` must not be wrong.
void add_role(X509& certificate, const std::string& role);

/// What a gateway reads in a certificate.
struct ReadRole {
  std::optional<std::string> role{};  ///< none: the NULL role
  bool is_unreadable = false;         ///< empty, no UTF8String in UTF-8, or there twice
};
ReadRole read_role(const X509& certificate);

}  // namespace mbgate::ctl

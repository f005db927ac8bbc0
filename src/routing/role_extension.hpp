// SPDX-License-Identifier: Apache-2.0
// The role in a client's certificate: the extension 1.3.6.1.4.1.50316.802.1, a UTF8String, which is
// the role as a whole (MB-TCP-Security v36, R-21, R-22, R-65). Pure: bytes in, role out.
#pragma once

#include <cstddef>
#include <span>

#include "modbus/bytes.hpp"
#include "routing/client_role.hpp"

namespace mbgate::routing {

/// Of the extension, as text.
inline constexpr const char* kRoleExtension = "1.3.6.1.4.1.50316.802.1";

/// In bytes. More is no name that anybody has given; a certificate with it is not understood.
inline constexpr std::size_t kLongestRole = 255;

/// What a certificate says with these values of the extension, each in DER; none: the NULL role
/// . Two roles, an empty one, another type and wrong DER are unreadable.
ClientRole role_of(std::span<const modbus::Bytes> values);

}  // namespace mbgate::routing

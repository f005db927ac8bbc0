// SPDX-License-Identifier: Apache-2.0
#include "routing/client_role.hpp"

#include <algorithm>
#include <optional>
#include <string_view>

#include "base/utf8.hpp"

namespace mbgate::routing {

bool ClientList::contains(const ClientAddress& address, const ClientRole& role) const {
  const bool has_role =
      role.kind == ClientRole::Kind::named && std::ranges::find(roles, role.name) != roles.end();
  const bool has_certificate =
      !role.certificate.empty() &&
      std::ranges::find(certificates, role.certificate) != certificates.end();
  return has_role || has_certificate || routing::contains(networks, address);
}

namespace {

using modbus::Bytes;

constexpr std::uint8_t kUtf8String = 0x0C;
/// A length from here on stands in bytes of its own (X.690, 8.1.3).
constexpr std::uint8_t kLongLength = 0x80;

/// The contents of a UTF8String that is all of these bytes. DER has one form for each length; up to
/// 255 it is one byte, or 0x81 and one byte of 128 or more.
std::optional<std::string> contents_of(Bytes der) {
  if (der.size() < 2 || der[0] != kUtf8String) {
    return std::nullopt;
  }
  std::size_t length = der[1];
  std::size_t head = 2;
  if (der[1] == kLongLength + 1 && der.size() > 2 && der[2] >= kLongLength) {
    length = der[2];
    head = 3;
  } else if (der[1] >= kLongLength) {
    return std::nullopt;
  }
  if (length > kLongestRole || der.size() != head + length) {
    return std::nullopt;
  }
  return std::string(der.begin() + static_cast<std::ptrdiff_t>(head), der.end());
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t size = first_character(text).size;
    if (size == 0) {
      return false;
    }
    text.remove_prefix(size);
  }
  return true;
}

}  // namespace

ClientRole role_of(std::span<const Bytes> values) {
  if (values.empty()) {
    return {ClientRole::Kind::named, {}};
  }
  const auto role = values.size() == 1 ? contents_of(values[0]) : std::nullopt;
  if (!role || role->empty() || !is_utf8(*role)) {
    return {ClientRole::Kind::unreadable, {}};
  }
  return {ClientRole::Kind::named, *role};
}

}  // namespace mbgate::routing

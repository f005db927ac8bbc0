// SPDX-License-Identifier: Apache-2.0
#include "soak/certificates.hpp"

#include <array>
#include <cstdint>
#include <vector>

#include "routing/role_extension.hpp"

namespace mbgate::soak {
namespace {

using Octets = std::vector<std::uint8_t>;
using RoleIs = routing::ClientRole::Kind;

constexpr std::uint8_t kUtf8String = 0x0C;
constexpr std::uint8_t kPrintableString = 0x13;

Octets extension_of(std::uint8_t type, const Octets& text) {
  Octets der{type, static_cast<std::uint8_t>(text.size())};
  der.insert(der.end(), text.begin(), text.end());
  return der;
}

// No role that anybody has given: an empty one, none of UTF-8, another type, two at once, what is
// shorter than it says.
std::vector<Octets> unreadable_extensions(unsigned host) {
  const Octets role = extension_of(kUtf8String, {'x'});
  const std::array<std::vector<Octets>, 5> kinds{{{extension_of(kUtf8String, {})},
                                                  {extension_of(kUtf8String, {0xC3})},
                                                  {extension_of(kPrintableString, {'x'})},
                                                  {role, role},
                                                  {{kUtf8String, 2, 'x'}}}};
  return kinds.at(host % kinds.size());
}

}  // namespace

routing::ClientRole read_in_certificate(const routing::ClientRole& role, unsigned host) {
  if (role.kind == RoleIs::none) {
    return role;
  }
  std::vector<Octets> extensions;
  if (role.kind == RoleIs::unreadable) {
    extensions = unreadable_extensions(host);
  } else if (!role.name.empty()) {
    extensions.push_back(extension_of(kUtf8String, {role.name.begin(), role.name.end()}));
  }
  const std::vector<modbus::Bytes> values(extensions.begin(), extensions.end());
  return routing::role_of(values);
}

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
// The extension of a certificate that says a role. The bytes are one value of it. What is read as a
// role is those bytes again when it is written by the rules of DER; whatever else is unreadable.
#include <array>
#include <vector>

#include "fuzz/fuzz.hpp"
#include "routing/client_address.hpp"

namespace mbgate::fuzz::role_target {
namespace {

using routing::ClientRole;

std::vector<std::uint8_t> utf8_string(const std::string& text) {
  std::vector<std::uint8_t> der = {0x0C};
  if (text.size() >= 128) {
    der.push_back(0x81);
  }
  der.push_back(static_cast<std::uint8_t>(text.size()));
  der.insert(der.end(), text.begin(), text.end());
  return der;
}

}  // namespace

MBGATE_FUZZ_TARGET(role) {
  const mbgate::modbus::Bytes bytes(data, size);
  const ClientRole role = mbgate::routing::role_of(std::array{bytes});
  require(role.kind != ClientRole::Kind::none, "a certificate was shown");
  if (role.kind == ClientRole::Kind::named) {
    require(!role.name.empty() && role.name.size() < 256, "a role is a short text");
    require(std::ranges::equal(utf8_string(role.name), bytes), "a role is all of its bytes");
  } else {
    require(role.name.empty(), "what is unreadable has no name");
  }
  require(mbgate::routing::role_of(std::array{bytes, bytes}).kind == ClientRole::Kind::unreadable,
          "nobody has two roles");
  return 0;
}

}  // namespace mbgate::fuzz::role_target

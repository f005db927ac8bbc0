// SPDX-License-Identifier: Apache-2.0
#include "world/hosts.hpp"

#include <array>
#include <cstdint>
#include <string>

namespace mbgate::world {
namespace {

enum class Form : std::uint8_t { v4, v6, mapped, network_v6, network_v4 };

// Those whose numbers differ by five have the same form: only its last bits tell their networks
// apart.
constexpr std::array kForms{Form::v4, Form::v6, Form::mapped, Form::network_v6, Form::network_v4};

Form form_of(unsigned host) { return kForms.at(host % kForms.size()); }

// The third octet of a host's IPv4 network, of which three bits count.
unsigned block_of(unsigned host) { return host / static_cast<unsigned>(kForms.size()) * 32; }

std::uint8_t octet(unsigned value) { return static_cast<std::uint8_t>(value); }

// 10.a.b.c as an IPv6 address.
routing::ClientAddress::Octets v4(unsigned a, unsigned b, unsigned c) {
  routing::ClientAddress::Octets octets{};
  octets[10] = octets[11] = 0xFF;
  octets[12] = 10;
  octets[13] = octet(a);
  octets[14] = octet(b);
  octets[15] = octet(c);
  return octets;
}

// fd00:0:0:a::b.
routing::ClientAddress::Octets v6(unsigned a, unsigned b) {
  routing::ClientAddress::Octets octets{};
  octets[0] = 0xFD;
  octets[7] = octet(a);
  octets[15] = octet(b);
  return octets;
}

std::string hex_digit(unsigned value) { return std::string(1, "0123456789abcdef"[value % 16]); }

}  // namespace

routing::ClientAddress address_of(unsigned host) {
  switch (form_of(host)) {
    case Form::v4:
    case Form::mapped: break;
    case Form::v6: return routing::ClientAddress(v6(16 * host + 3, host + 1));  // each is a client
    case Form::network_v6: return routing::ClientAddress(v6(16 * host + 7, 9));
    case Form::network_v4: return routing::ClientAddress(v4(1, block_of(host) + 29, 9));
  }
  return routing::ClientAddress(v4(0, 0, host + 1));
}

routing::Network network_of(unsigned host) {
  std::string text;
  switch (form_of(host)) {
    case Form::v4: text = "10.0.0." + std::to_string(host + 1); break;
    case Form::v6: text = "fd00:0:0:" + hex_digit(host) + "3::" + hex_digit(host + 1); break;
    case Form::mapped: text = "::ffff:10.0.0." + std::to_string(host + 1); break;
    case Form::network_v6: text = "fd00:0:0:" + hex_digit(host) + "0::/60"; break;
    case Form::network_v4: text = "10.1." + std::to_string(block_of(host)) + ".0/19"; break;
  }
  return *routing::Network::parse(text);
}

std::string text_of(unsigned host) {
  switch (form_of(host)) {
    case Form::v4:
    case Form::mapped: break;
    case Form::v6: return "fd00:0:0:" + hex_digit(host) + "3::" + hex_digit(host + 1);
    case Form::network_v6: return "fd00:0:0:" + hex_digit(host) + "7::9";
    case Form::network_v4: return "10.1." + std::to_string(block_of(host) + 29) + ".9";
  }
  return "10.0.0." + std::to_string(host + 1);
}

routing::NetworkList networks_of(const std::vector<unsigned>& hosts) {
  routing::NetworkList networks;
  for (const unsigned host : hosts) {
    networks.push_back(network_of(host));
  }
  return networks;
}

}  // namespace mbgate::world

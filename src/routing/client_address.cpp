// SPDX-License-Identifier: Apache-2.0
#include "routing/client_address.hpp"

#include <arpa/inet.h>

#include <algorithm>

#include "base/text.hpp"
#include "base/utf8.hpp"

namespace mbgate::routing {
namespace {

constexpr std::size_t kV4Offset = 12;  // ::ffff:a.b.c.d
constexpr unsigned kV4Prefix = 96;
constexpr unsigned kAllBits = 128;
constexpr unsigned kNetworkBits = 64;  // of an IPv6 address; the others are the interface's

// Without the bits beyond the prefix.
ClientAddress network_of(const ClientAddress& address, unsigned prefix) {
  ClientAddress::Octets octets = address.octets();
  for (unsigned bit = prefix; bit < kAllBits; ++bit) {
    octets[bit / 8] = static_cast<std::uint8_t>(octets[bit / 8] & ~(0x80U >> bit % 8));
  }
  return ClientAddress(octets);
}

}  // namespace

std::optional<ClientAddress> ClientAddress::parse(std::string_view text) {
  if (text.find('\0') != std::string_view::npos) {
    return std::nullopt;  // inet_pton() would not see what lies behind it
  }
  const std::string terminated(text);
  Octets octets{};
  if (inet_pton(AF_INET, terminated.c_str(), &octets[kV4Offset]) == 1) {
    octets[10] = octets[11] = 0xFF;
    return ClientAddress(octets);
  }
  if (inet_pton(AF_INET6, terminated.c_str(), octets.data()) == 1) {
    return ClientAddress(octets);
  }
  return std::nullopt;
}

bool ClientAddress::is_v4() const {
  return std::all_of(octets_.begin(), octets_.begin() + 10,
                     [](auto octet) { return octet == 0; }) &&
         octets_[10] == 0xFF && octets_[11] == 0xFF;
}

std::string ClientAddress::to_text() const {
  char text[INET6_ADDRSTRLEN] = "";
  if (is_v4()) {
    inet_ntop(AF_INET, &octets_[kV4Offset], text, sizeof text);
  } else {
    inet_ntop(AF_INET6, octets_.data(), text, sizeof text);
  }
  return text;
}

ClientAddress ClientAddress::counted_as() const {
  return is_v4() ? *this : network_of(*this, kNetworkBits);
}

std::optional<Network> Network::parse(std::string_view text) {
  const auto slash = text.find('/');
  const auto address = ClientAddress::parse(text.substr(0, slash));
  if (!address) {
    return std::nullopt;
  }
  const bool v4 = text.substr(0, slash).find(':') == std::string_view::npos;
  unsigned prefix = v4 ? 32 : kAllBits;
  if (slash != std::string_view::npos) {
    const auto given = integer_in<unsigned>(text.substr(slash + 1));
    if (!given || *given > prefix) {
      return std::nullopt;
    }
    prefix = *given;
  }
  if (v4) {
    prefix += kV4Prefix;
  }
  if (*address != network_of(*address, prefix)) {
    return std::nullopt;
  }
  return Network(*address, prefix);
}

bool Network::contains(const ClientAddress& address) const {
  return address_ == network_of(address, prefix_);
}

bool Network::contains(const Network& other) const {
  return prefix_ <= other.prefix_ && contains(other.address_);
}

bool contains(const NetworkList& list, const ClientAddress& address) {
  return std::ranges::any_of(list,
                             [&](const Network& network) { return network.contains(address); });
}

bool have_common(const NetworkList& a, const NetworkList& b) {
  return std::ranges::any_of(a, [&](const Network& one) {
    return std::ranges::any_of(
        b, [&](const Network& other) { return one.contains(other) || other.contains(one); });
  });
}

std::optional<ListenAddress> ListenAddress::parse(std::string_view text) {
  const auto place = host_and_port(text);
  const auto address = place ? ClientAddress::parse(place->host) : std::nullopt;
  return address ? std::optional(ListenAddress{*address, place->port}) : std::nullopt;
}

NetworkList loopback_networks() { return {*Network::parse("127.0.0.0/8"), *Network::parse("::1")}; }

bool is_loopback(const ClientAddress& address) { return contains(loopback_networks(), address); }

bool is_link_local(const ClientAddress& address) {
  return Network::parse("fe80::/10")->contains(address);
}

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

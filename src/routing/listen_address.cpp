// SPDX-License-Identifier: Apache-2.0
#include "routing/listen_address.hpp"

#include "base/host_and_port.hpp"

namespace mbgate::routing {

std::optional<ListenAddress> ListenAddress::parse(std::string_view text) {
  const auto place = host_and_port(text);
  const auto address = place ? ClientAddress::parse(place->host) : std::nullopt;
  return address ? std::optional(ListenAddress{*address, place->port}) : std::nullopt;
}

NetworkList loopback_networks() { return {*Network::parse("127.0.0.0/8"), *Network::parse("::1")}; }

bool is_loopback(const ClientAddress& address) { return contains(loopback_networks(), address); }

}  // namespace mbgate::routing

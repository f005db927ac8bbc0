// SPDX-License-Identifier: Apache-2.0
#include "routing/listen_address.hpp"

#include <charconv>
#include <system_error>

namespace mbgate::routing {
namespace {

std::optional<std::uint16_t> parse_port(std::string_view digits) {
  std::uint16_t port = 0;
  const auto* const end = digits.data() + digits.size();
  const auto [at, error] = std::from_chars(digits.data(), end, port);
  return error == std::errc{} && at == end ? std::optional(port) : std::nullopt;
}

}  // namespace

std::optional<ListenAddress> ListenAddress::parse(std::string_view text) {
  const auto colon = text.rfind(':');
  if (colon == std::string_view::npos) {
    return std::nullopt;
  }
  auto host = text.substr(0, colon);
  const bool bracketed = host.starts_with('[') && host.ends_with(']');
  if (bracketed) {
    host = host.substr(1, host.size() - 2);
  }
  const bool v6 = host.find(':') != std::string_view::npos;
  const auto address = ClientAddress::parse(host);
  const auto port = parse_port(text.substr(colon + 1));
  if (bracketed != v6 || !address || !port) {
    return std::nullopt;
  }
  return ListenAddress{*address, *port};
}

NetworkList loopback_networks() { return {*Network::parse("127.0.0.0/8"), *Network::parse("::1")}; }

bool is_loopback(const ClientAddress& address) { return contains(loopback_networks(), address); }

}  // namespace mbgate::routing

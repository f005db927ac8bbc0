// SPDX-License-Identifier: Apache-2.0
#include "sim/program/listen_address.hpp"

#include <arpa/inet.h>

#include <charconv>

namespace mbgate::sim {

std::optional<ListenAddress> ListenAddress::parse(std::string_view text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) {
    return std::nullopt;
  }
  ListenAddress address{std::string(text.substr(0, colon))};
  const std::string_view port = text.substr(colon + 1);
  const char* const end = port.data() + port.size();
  const auto number = std::from_chars(port.data(), end, address.port);
  in_addr unused{};
  const bool valid = number.ec == std::errc{} && number.ptr == end &&
                     ::inet_pton(AF_INET, address.host.c_str(), &unused) == 1;
  return valid ? std::optional(address) : std::nullopt;
}

}  // namespace mbgate::sim

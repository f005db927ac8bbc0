// SPDX-License-Identifier: Apache-2.0
// Where a simulated bus listens: an IPv4 address and a port, "127.0.0.1:1502".
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace mbgate::sim {

struct ListenAddress {
  std::string host = "127.0.0.1";
  std::uint16_t port = 0;  ///< 0: the kernel chooses

  static std::optional<ListenAddress> parse(std::string_view text);
  [[nodiscard]] std::string text() const { return host + ':' + std::to_string(port); }
  friend bool operator==(const ListenAddress&, const ListenAddress&) = default;
};

}  // namespace mbgate::sim

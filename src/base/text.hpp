// SPDX-License-Identifier: Apache-2.0
// Numbers and lists in texts: written for people, and read from what people wrote.
#pragma once

#include <charconv>
#include <chrono>
#include <cstdint>
#include <fmt/core.h>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace mbgate {

/// "1 stop", "2 stops".
inline std::string counted(std::uint64_t count, std::string_view one) {
  return fmt::format("{} {}{}", count, one, count == 1 ? "" : "s");
}

/// "1 bus", "2 buses".
inline std::string counted(std::uint64_t count, std::string_view one, std::string_view many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

/// Whole units that are over: "5 s", "12 min", "3 h", "9 days".
template <typename Number, typename Unit>
std::string passed_text(std::chrono::duration<Number, Unit> time) {
  using namespace std::chrono;
  if (time < minutes(2)) {
    return fmt::format("{} s", floor<seconds>(time).count());
  }
  if (time < hours(2)) {
    return fmt::format("{} min", floor<minutes>(time).count());
  }
  return time < days(2) ? fmt::format("{} h", floor<hours>(time).count())
                        : fmt::format("{} days", floor<days>(time).count());
}

/// The result of `text`, a function or a member, for each element, joined by `between`.
template <typename List, typename Text>
std::string joined(const List& list, Text text, std::string_view between = ", ") {
  std::string all;
  for (const auto& element : list) {
    all.append(all.empty() ? "" : between).append(std::invoke(text, element));
  }
  return all;
}

/// The integer that is the whole of a text; nothing if there is more, or if it does not fit.
template <typename Integer>
std::optional<Integer> integer_in(std::string_view text, int base = 10) {
  Integer number{};
  const char* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number, base);
  return error == std::errc{} && at == end ? std::optional(number) : std::nullopt;
}

// "host:port", "[::1]:port": an IPv6 address stands in brackets, and nothing else does.

struct HostAndPort {
  std::string host;
  std::uint16_t port;
};

inline std::optional<HostAndPort> host_and_port(std::string_view text) {
  const auto colon = text.rfind(':');
  if (colon == std::string_view::npos) {
    return std::nullopt;
  }
  auto host = text.substr(0, colon);
  const bool is_bracketed = host.starts_with('[') && host.ends_with(']');
  if (is_bracketed) {
    host = host.substr(1, host.size() - 2);
  }
  const auto port = integer_in<std::uint16_t>(text.substr(colon + 1));
  if (!port || is_bracketed != (host.find(':') != std::string_view::npos)) {
    return std::nullopt;
  }
  return HostAndPort{std::string(host), *port};
}

/// The same of a server: its port is not 0, its host a name or an address.
inline std::optional<HostAndPort> server_in(std::string_view text) {
  auto server = host_and_port(text);
  const bool is_one = server && server->port != 0 && !server->host.empty() &&
                      server->host.find_first_of("/[]@ ") == std::string::npos;
  return is_one ? server : std::nullopt;
}

inline std::string host_and_port(std::string_view host, std::uint16_t port) {
  return host.find(':') == std::string_view::npos ? fmt::format("{}:{}", host, port)
                                                  : fmt::format("[{}]:{}", host, port);
}

}  // namespace mbgate

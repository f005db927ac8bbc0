// SPDX-License-Identifier: Apache-2.0
// The user or address that has connected to the HTTP interface, and a limit on how often it may
// change something.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

#include "routing/client_address.hpp"

namespace mbgate::app {

struct Asker {
  std::string client;  ///< what limits go by
  std::string text;    ///< for the journal
};

/// Over TCP: "192.168.10.5".
Asker asker_of(const routing::ClientAddress& address);

/// Over a Unix socket, as the kernel says: "uid 1000", and "uid 1000, pid 4711".
Asker asker_of_unix_socket(int descriptor);

/// How many commands, requests that change something, a client may give within a second. Pure: the
/// time is handed in.
class CommandLimit {
 public:
  static constexpr std::size_t kMostASecond = 10;
  using Instant = std::chrono::steady_clock::time_point;

  /// `first_too_many`: the first of this second that is refused.
  enum class Verdict : std::uint8_t { allowed, first_too_many, too_many };

  Verdict count(const std::string& client, Instant now) {
    // Clients are users of this machine; what was is of no use any more.
    std::erase_if(seconds_, [&](const auto& entry) {
      return now - entry.second.begin >= std::chrono::seconds(1);
    });
    const std::size_t given = ++seconds_.try_emplace(client, Second{now}).first->second.given;
    if (given <= kMostASecond) {
      return Verdict::allowed;
    }
    return given == kMostASecond + 1 ? Verdict::first_too_many : Verdict::too_many;
  }

 private:
  struct Second {
    Instant begin;
    std::size_t given = 0;
  };
  std::map<std::string, Second> seconds_;
};

}  // namespace mbgate::app

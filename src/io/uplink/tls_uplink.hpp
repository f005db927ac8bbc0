// SPDX-License-Identifier: Apache-2.0
// A TCP connection to a server, over TLS, for a line that knows nothing of that: it gets one end of
// a pair of sockets. The handshake, the records and what the signer is asked are on a thread of
// this connection's own, because they take longer than a line may wait.
//
// As soon as the handshake is done, one byte comes out of the pair, kReady; then what the server
// says. Before its end comes, why() knows the reason. What the line has written is sent at once.
// When the line closes its end, nothing is sent any more, and what the kernel still holds is thrown
// away: no request goes out late.
#pragma once

#include <cstdint>
#include <future>
#include <optional>
#include <string>
#include <utility>

#include "bus/settings.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::io {

class TlsUplink {
 public:
  static constexpr std::uint8_t kReady = 0x01;

  /// `server` is connected. Nothing if there can be no thread or no pair of sockets. The thread
  /// ends by itself as soon as the line's end is closed.
  static std::optional<TlsUplink> start(sys::UniqueFd server, bus::TlsPeer peer);

  /// The line's end of the pair; the caller's from then on. It does not block.
  [[nodiscard]] sys::UniqueFd take_line_end() { return std::move(line_end_); }

  /// Why the pair has come to its end; empty: it has not, or the server has closed the connection.
  [[nodiscard]] std::string why() const;

 private:
  TlsUplink(sys::UniqueFd line_end, std::shared_future<std::string> ended)
      : line_end_(std::move(line_end)), ended_(std::move(ended)) {}

  sys::UniqueFd line_end_;
  std::shared_future<std::string> ended_;
};

}  // namespace mbgate::io

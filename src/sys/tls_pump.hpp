// SPDX-License-Identifier: Apache-2.0
// Carries bytes between a TLS stream and a plain socket, which is one end of a pair: the code at
// the other end needs no TLS. It blocks, on a thread of its own, and holds a few kilobytes.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sys/tls_stream.hpp"

namespace mbgate::sys {

class TlsPump {
 public:
  enum class End : std::uint8_t {
    none,    ///< the handshake is done
    plain,   ///< the other end of the pair was closed
    late,    ///< the time is over
    stream,  ///< that of the stream, as last_step() and the stream say
  };

  /// `socket`: that of the stream. Neither it nor `plain` (-1: none yet) blocks.
  TlsPump(TlsStream& stream, int socket, int plain)
      : stream_(stream), socket_(socket), plain_(plain) {}

  /// Nothing as the limit: for ever.
  End shake_hands(std::optional<std::chrono::steady_clock::time_point> limit);
  /// Until there is an end. `stall_limit`: how long the other end of the stream may take nothing of
  /// what it is sent.
  End carry(std::optional<std::chrono::milliseconds> stall_limit);

  [[nodiscard]] TlsStream::Step last_step() const { return last_step_; }
  /// Do we, or does the kernel, hold what the other end of the stream has not taken?
  [[nodiscard]] bool has_unsent() const;

 private:
  enum class Move : std::uint8_t { done, must_wait, ended };
  /// Bytes on their way in one direction.
  struct Portion {
    std::array<std::uint8_t, 2048> bytes{};
    std::size_t begin = 0;
    std::size_t end = 0;

    [[nodiscard]] bool is_empty() const { return begin == end; }
    [[nodiscard]] std::span<const std::uint8_t> left() const {
      return std::span(bytes).subspan(begin, end - begin);
    }
    void fill(std::size_t count) {
      begin = 0;
      end = count;
    }
  };

  Move carry_up();
  Move carry_down();
  Move move_after(TlsStream::Step step);
  Move end_with(End end);
  void wait(short plain_events, std::chrono::milliseconds time);
  [[nodiscard]] bool is_plain_closed() const;

  TlsStream& stream_;
  int socket_;
  int plain_;
  short events_ = 0;  ///< that the socket is waited for
  Portion up_;
  Portion down_;
  End end_ = End::none;
  TlsStream::Step last_step_ = TlsStream::Step::done;
};

}  // namespace mbgate::sys

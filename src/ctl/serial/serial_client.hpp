// SPDX-License-Identifier: Apache-2.0
// Asks the units of a serial line, one read at a time, without a gateway. Not over libmodbus: it
// neither says how many bytes it heard, nor shows a frame of another unit, takes an unknown rate
// for 9600 baud, and opens the port by itself, without a lock.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ctl/serial/heard.hpp"
#include "ctl/serial/serial_port.hpp"

namespace mbgate::ctl {

/// After a change of the mode an adapter needs time, and the units what is left of a frame.
inline constexpr std::chrono::milliseconds kModeSettling{20};
/// The least pause after bytes that were not understood: they may have more behind them.
inline constexpr std::chrono::milliseconds kPauseAfterNoise{5};

/// How long ask_all() listens. Whatever comes, it ends when the longest frame that begins at the
/// end of `wait` must be whole.
struct ListenTimes {
  std::chrono::nanoseconds wait;          ///< for an answer, after the request
  std::chrono::nanoseconds after_answer;  ///< for a second one
  std::chrono::nanoseconds after_bytes;   ///< a pause of this length ends a frame
};

/// Whether the asker wants it to end now; asked ten times a second, and after each piece.
using IsOver = std::function<bool()>;

/// Bytes that came together.
struct Piece {
  std::chrono::nanoseconds at;  ///< after the request has left, or since listening began
  std::vector<std::uint8_t> bytes;
};

class SerialClient {
 public:
  /// Opens the port and locks it; the error is for port_failure(). set_mode() comes next.
  static Result<SerialClient, int> open(const std::string& device);

  /// Why the port cannot have this mode, or nothing.
  std::optional<std::string> set_mode(const LineMode& mode);
  /// When the next frame may go out: t3.5 after the last one, if not later. Whoever asks waits.
  [[nodiscard]] std::chrono::steady_clock::time_point ready_at() const { return ready_at_; }
  /// Sends a read and listens until its answer is there, or nothing has come for `wait` after the
  /// request and all is quiet. The error is a full sentence: the port is of no more use.
  Result<Heard, std::string> ask(std::uint8_t unit, const modbus::TableRange& read,
                                 std::chrono::nanoseconds wait);
  /// Sends a read and takes all that comes, also what comes after its answer, and what already lay
  /// there. The request has left when its characters have had their time.
  Result<std::vector<Piece>, std::string> ask_all(const SentRead& sent, const ListenTimes& times,
                                                  const IsOver& is_over);
  /// Sends nothing. It may end early where much is heard.
  Result<std::vector<Piece>, std::string> overhear(std::chrono::nanoseconds time);

 private:
  using Instant = std::chrono::steady_clock::time_point;
  SerialClient(std::string device, SerialPort port)
      : device_(std::move(device)), port_(std::move(port)) {}
  std::optional<std::string> send(modbus::Bytes frame);
  /// Takes what comes until `end`, which each piece moves; nothing: it was the last one.
  using NextEnd = std::function<std::optional<Instant>(Instant end)>;
  Result<std::vector<Piece>, std::string> take_pieces(
      Instant begin, Instant end, const NextEnd& next_end,
      const IsOver& is_over = [] { return false; });
  /// The next frame goes out after t3.5, and not before this pause.
  void rest(std::chrono::nanoseconds pause);
  /// Appends what comes until `until`. Nothing if nothing came.
  Result<std::optional<Piece>, std::string> take_piece(Instant begin, Instant until);
  [[nodiscard]] bool is_full() const;
  [[nodiscard]] modbus::Bytes received() const { return {received_.data(), received_.size()}; }

  std::string device_;
  SerialPort port_;
  LineMode mode_;
  std::chrono::steady_clock::time_point ready_at_{};
  std::vector<std::uint8_t> received_;
  std::chrono::steady_clock::time_point last_received_{};
};

}  // namespace mbgate::ctl

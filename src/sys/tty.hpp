// SPDX-License-Identifier: Apache-2.0
// Serial lines and pseudo-terminals as the kernel has them: taken for one program alone, and set to
// raw bytes at any rate. Drivers silently replace what they cannot do, so a mode is read back.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sys/unique_fd.hpp"

namespace mbgate::sys {

enum class TtyParity : std::uint8_t { none, even, odd };

struct TtyMode {
  std::uint32_t baud = 9600;
  unsigned data_bits = 8;
  TtyParity parity = TtyParity::none;
  unsigned stop_bits = 1;
  /// A character of the wrong parity reads as 0.
  bool checks_parity = false;

  /// "8E1"
  [[nodiscard]] std::string format_text() const;
  /// Apart from the rate.
  [[nodiscard]] bool has_format_of(const TtyMode& other) const {
    return data_bits == other.data_bits && parity == other.parity && stop_bits == other.stop_bits;
  }
  /// At most 2 % off, which is the receiver's share of the tolerance (Serial Line V1.02, 2.5.1).
  [[nodiscard]] bool has_rate_near(std::uint32_t asked) const;
};

/// Opens it for this program alone, without waiting for a carrier. TIOCEXCL does not stop root, and
/// flock stops only those who ask: both together stop everyone who looks. Closed where it cannot be
/// had, and errno says why: EBUSY: another program uses it; ENOTTY: it is no tty.
UniqueFd open_tty(const std::string& device);
/// Lets others have it.
void release_tty(int fd);

bool is_pseudo_terminal(int fd);

/// What the driver does now. Nothing: errno says why.
std::optional<TtyMode> tty_mode(int fd);
/// Raw bytes without flow control; reads wait for one byte. What the driver then does, or nothing.
std::optional<TtyMode> set_tty_mode(int fd, const TtyMode& mode);

/// All settings, to be given back as they are; empty where they cannot be read.
using TtySettings = std::vector<std::uint8_t>;
TtySettings read_tty_settings(int fd);
/// Waits for nothing.
void restore_tty_settings(int fd, const TtySettings& settings);

/// Discards what was not sent yet, and what was received and not read.
void discard_output(int fd);
void discard_all(int fd);

/// What can be read.
std::size_t bytes_to_read(int fd);
/// What was given to the driver and has not left, as far as it knows. Drivers that cannot say so
/// hold nothing: the TIOCOUTQ of a pty is always 0.
std::size_t bytes_to_send(int fd);

}  // namespace mbgate::sys

// SPDX-License-Identifier: Apache-2.0
// A pty in place of a serial port, and the symbolic link to it. Both are removed with the object.
// Part of the simulator's shell.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "modbus/bytes.hpp"
#include "modbus/result.hpp"
#include "modbus/rtu_timing.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::sim {

/// Linux keeps neither parity nor data bits of a pty.
struct PtySpeed {
  modbus::Baud baud{115200};
  unsigned stop_bits = 1;
};

class Pty {
 public:
  /// Error: a sentence that names the link and what is wrong. An existing link is replaced if it
  /// leads nowhere or to this pty; anything else in its place is left alone. Until a client sets
  /// its port, the pty is set to `speed`.
  static Result<Pty, std::string> open(const std::filesystem::path& link, PtySpeed speed = {});

  Pty(Pty&&) = default;
  Pty& operator=(Pty&&) = delete;
  Pty(const Pty&) = delete;
  Pty& operator=(const Pty&) = delete;
  /// Removes the link if it is still ours.
  ~Pty();

  [[nodiscard]] int descriptor() const { return controller_.get(); }
  /// "/dev/pts/7".
  [[nodiscard]] const std::string& path() const { return path_; }

  /// The speed that the other side has set; nothing if the system does not say.
  [[nodiscard]] std::optional<PtySpeed> speed() const;
  /// What the other side has written since the last call; never blocks.
  [[nodiscard]] std::vector<std::uint8_t> read() const;
  /// If nobody reads and the pty is full, the bytes are lost, as on a serial line.
  void write(modbus::Bytes bytes) const;
  /// A terminal that was opened exclusively (TIOCEXCL) stays so until its last close, and the
  /// simulator keeps the pty open: without this a program could not open its port a second time.
  void release_exclusive() const;

 private:
  Pty(sys::UniqueFd controller, sys::UniqueFd port, std::string path, std::filesystem::path link);

  sys::UniqueFd controller_;
  sys::UniqueFd port_;  ///< held open, so that a client's close is not a hang-up for us
  std::string path_;
  std::filesystem::path link_;
};

}  // namespace mbgate::sim

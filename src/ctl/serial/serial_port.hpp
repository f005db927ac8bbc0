// SPDX-License-Identifier: Apache-2.0
// A serial port for our use alone, with the locks that mbgated takes, and sentences for people
// where it cannot be had. A program that has the port open without a lock loses nothing but what
// comes meanwhile: it gets its settings back.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "modbus/result.hpp"
#include "modbus/rtu_timing.hpp"
#include "sys/tty.hpp"

namespace mbgate::ctl {

/// How characters are sent on a serial line: rate, parity, stop bits. RTU, so always 8 data bits.
struct LineMode {
  modbus::Baud baud{9600};
  modbus::CharacterFormat format{};
  friend bool operator==(const LineMode&, const LineMode&) = default;
};

/// "9600 8E1"
std::string mode_text(const LineMode& mode);

/// Every rate with every parity, in the order of the lists: "9600,19200", "even,none,odd" and "1",
/// "2" or "1,2". The stop bits are those without a parity: with one there is always 1. The error is
/// a full sentence.
Result<std::vector<LineMode>, std::string> parse_modes(std::string_view bauds,
                                                       std::string_view parities,
                                                       std::string_view stop_bits);

inline constexpr const char* kSerialNames = "/dev/serial/by-id";

class SerialPort {
 public:
  /// Opens the port and locks it; its mode is that of before. The error is for port_failure().
  static Result<SerialPort, int> open(const std::string& device);

  SerialPort(SerialPort&&) = default;
  SerialPort& operator=(SerialPort&&) = delete;
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;
  ~SerialPort();

  [[nodiscard]] int descriptor() const { return fd_.get(); }
  /// Why the port cannot have this mode, or nothing. Bytes that wait are discarded, then and in the
  /// end, when the port gets the settings of before.
  [[nodiscard]] std::optional<std::string> set_mode(const LineMode& mode);

 private:
  explicit SerialPort(sys::UniqueFd fd) : fd_(std::move(fd)) {}

  sys::UniqueFd fd_;
  std::optional<sys::TtySettings> before_{};  ///< once the mode was set
};

/// The paths in `folder`, by default the lasting names of serial ports; sorted.
std::vector<std::string> paths_in(const std::string& folder = kSerialNames);

/// What to say where open() of `device` has failed with `error`; EBUSY: another program holds it.
/// `names` are those of the ports that there are.
std::string port_failure(const std::string& device, int error,
                         const std::vector<std::string>& names = paths_in());

/// The path among `names` that leads to the same port as `device` and is another one: it stays the
/// same where adapters are plugged in otherwise.
std::optional<std::string> lasting_name(const std::string& device,
                                        const std::vector<std::string>& names);

}  // namespace mbgate::ctl

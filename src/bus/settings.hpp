// SPDX-License-Identifier: Apache-2.0
// What a bus is told: its line, its times, its limits. Names and meanings are those of
// conf/mbgate.toml.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "bus/instant.hpp"
#include "drive/device.hpp"
#include "modbus/rtu_timing.hpp"

namespace mbgate::bus {

enum class Rs485 : std::uint8_t { off, kernel, rts };

/// What a frame looks like on the line.
enum class Framing : std::uint8_t { rtu, ascii, tcp };

/// The far end of a TCP connection.
struct Endpoint {
  std::string host;
  std::uint16_t port = 502;
  friend bool operator==(const Endpoint&, const Endpoint&) = default;
};

struct LineSettings {
  Framing framing = Framing::rtu;
  /// Set: a TCP connection in place of a serial line. Framing tcp always has one; with rtu and
  /// ascii a serial device server is behind it.
  std::optional<Endpoint> remote;
  std::string device;  ///< path, best one below /dev/serial/by-id
  modbus::Baud baud{19200};
  modbus::CharacterFormat format;
  Rs485 rs485 = Rs485::off;
  bool echo = false;  ///< the transceiver hears itself: the echo is read and compared
  bool low_latency = true;
  friend bool operator==(const LineSettings&, const LineSettings&) = default;
};

struct BusSettings {
  std::string name;
  LineSettings line;
  /// For addresses without a device of their own.
  drive::DeviceTiming timing;
  std::optional<Duration> frame_gap;     ///< default: t3.5
  std::optional<Duration> listen_first;  ///< default: the longest response timeout, at most 1 s
  Duration turnaround = std::chrono::milliseconds(100);
  Duration settle{0};
  std::size_t queue = 2048;  ///< requests waiting at most, stops not counted
  bool coalesce = true;      ///< identical waiting reads are transmitted once
  bool merge = false;        ///< adjacent and overlapping waiting reads are transmitted as one
  unsigned burst = 8;        ///< transactions of a class before one of a lower class goes
  /// A stop waits for the first byte of a running transaction's response at most so long; other
  /// stops, and writes that go first (`stop_cancels = false`), have so long for it from the end of
  /// their requests on. While writes that go first are held back it waits so long in all.
  Duration stop_wait = std::chrono::milliseconds(100);
  /// Percent of the bus's time that the probes of all its offline devices may take together.
  unsigned probe_share = 2;
  std::size_t outstanding = 1;  ///< framing tcp: requests on their way at a time
  Duration reopen_min = std::chrono::milliseconds(100);
  Duration reopen_max = std::chrono::seconds(5);
};

/// The longest that a response of this bus may be waited for: its devices', and the bus's own for
/// addresses without a device.
Duration longest_response_timeout(const BusSettings& settings,
                                  std::span<const drive::Device> devices);

}  // namespace mbgate::bus

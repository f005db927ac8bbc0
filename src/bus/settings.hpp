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

/// What an open line is, as far as the system tells.
enum class LineKind : std::uint8_t {
  uart,          ///< bytes leave and arrive at the pace of the wire
  adapter,       ///< a real one that does not keep the wire's pace: ttyACM, rfcomm
  virtual_line,  ///< a pseudo-terminal, a TCP connection
};

/// The far end of a TCP connection.
struct Endpoint {
  std::string host;
  std::uint16_t port = 502;
  friend bool operator==(const Endpoint&, const Endpoint&) = default;
};

/// What a TCP connection may cost until it is given up.
struct ConnectionTimes {
  /// For each address of the far end. Room for two repetitions of the SYN, which come after one and
  /// three seconds.
  Duration connect_timeout = std::chrono::seconds(4);
  /// What the far end has not acknowledged after so long is thrown away with the connection: a
  /// command that came out of a network that has been mended would be an old one. Room for three
  /// repetitions, the first of them after 200 ms.
  Duration acknowledge_timeout = std::chrono::seconds(2);
  /// An idle connection whose far end has gone without a word is noticed after so long. Whole
  /// seconds, at least 2.
  std::chrono::seconds idle_probe{15};
  friend bool operator==(const ConnectionTimes&, const ConnectionTimes&) = default;
};

struct LineSettings {
  Framing framing = Framing::rtu;
  /// Set: a TCP connection in place of a serial line. Framing tcp always has one; with rtu and
  /// ascii a serial device server is behind it.
  std::optional<Endpoint> remote;
  ConnectionTimes connection;  ///< with `remote`
  std::string device;          ///< path, best one below /dev/serial/by-id
  modbus::Baud baud{19200};
  modbus::CharacterFormat format;
  Rs485 rs485 = Rs485::off;
  /// rs485 = kernel: is RTS raised while sending (or lowered), and so long before and after it;
  /// none: as the driver has it, from the device tree.
  std::optional<bool> rs485_rts_on_send;
  std::optional<Duration> rs485_delay_before;
  std::optional<Duration> rs485_delay_after;
  /// The transceiver hears itself: the echo is read and compared. None: what the line shows.
  std::optional<bool> echo{};
  /// Bytes leave at the pace of the wire, so that nothing that begins before a request has left
  /// answers it. None: as the kind of the line says.
  std::optional<bool> paced{};
  bool low_latency = true;
  friend bool operator==(const LineSettings&, const LineSettings&) = default;
};

/// Slack for what lies between the wire and us: adapters hold received bytes back up to 16 ms.
inline constexpr Duration kAdapterSlack = std::chrono::milliseconds(20);

/// The same behind a serial device server: Wi-Fi and cellular ones pause for 60 ms and more.
inline constexpr Duration kNetworkSlack = std::chrono::milliseconds(200);

struct BusSettings {
  std::string name;
  bool is_gone = false;  ///< a reload took it away; nobody else gets its number
  LineSettings line;
  /// For addresses without a device of their own.
  drive::DeviceTiming timing;
  std::optional<Duration> frame_gap;     ///< default: t3.5
  std::optional<Duration> frame_slack;   ///< default: kAdapterSlack, or kNetworkSlack
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
  /// A stop that found no silence for so long on an open line is transmitted all the same. Default:
  /// 2 s, and no less than least_stop_deadline().
  std::optional<Duration> stop_deadline;
  /// Percent of the bus's time that the probes of all its offline devices may take together while
  /// somebody else asks.
  unsigned probe_share = 2;
  std::size_t outstanding = 1;  ///< framing tcp: requests on their way at a time
  /// Framing tcp: the unit of a response must be that of its request. Its transaction identifier
  /// suffices; many servers answer as unit 1 or 255.
  bool check_unit = false;
  /// Framing tcp: a connection on which so many requests went unanswered, and nothing came for 30 s
  /// meanwhile, is replaced; 0: never.
  unsigned replace_after = 5;
  Duration reopen_min = std::chrono::milliseconds(100);
  Duration reopen_max = std::chrono::seconds(5);
  /// A real adapter on which nothing was heard for so long, in which at least so many requests
  /// left, is closed and opened again; 0: never. The time doubles with each reopening up to
  /// `hung_max`, until something is heard.
  Duration hung_after = std::chrono::seconds(30);
  unsigned hung_requests = 10;
  Duration hung_max = std::chrono::minutes(10);

  /// For so long an RTU answer may pause in all, beyond the time that its bytes take, and for so
  /// long it must be silent behind what has no known end, and behind a bad CRC.
  [[nodiscard]] Duration frame_slack_or_default() const {
    return frame_slack.value_or(line.remote ? kNetworkSlack : kAdapterSlack);
  }
};

/// The longest that a response of this bus may be waited for: its devices', and the bus's own for
/// addresses without a device.
Duration longest_response_timeout(const BusSettings& settings,
                                  std::span<const drive::Device> devices);

/// The longest that one frame may keep a serial line busy, and a tenth more; 0 on a TCP connection.
Duration longest_stream(const BusSettings& settings);

/// A running transaction's answer, and the longest frame that may be under way, are over by then.
Duration least_stop_deadline(const BusSettings& settings);
Duration stop_deadline(const BusSettings& settings);

}  // namespace mbgate::bus

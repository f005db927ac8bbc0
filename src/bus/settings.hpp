// SPDX-License-Identifier: Apache-2.0
// The settings of a bus: its line, its times, its limits. Names and meanings are those of
// conf/mbgate.toml.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bus/instant.hpp"
#include "drive/device.hpp"
#include "modbus/rtu_timing.hpp"

namespace mbgate::bus {

enum class Rs485 : std::uint8_t { off, kernel, rts };

/// What a frame looks like on the line.
enum class Framing : std::uint8_t { rtu, ascii, tcp };

/// What an open line is, as far as the system says.
enum class LineKind : std::uint8_t {
  uart,          ///< bytes leave and arrive at the speed of the wire
  adapter,       ///< a physical one that does not keep the speed of the wire: ttyACM, rfcomm
  virtual_line,  ///< a pseudo-terminal, a TCP connection
};

/// The far end of a TCP connection.
struct Endpoint {
  std::string host;
  std::uint16_t port = 502;
  friend bool operator==(const Endpoint&, const Endpoint&) = default;
};

/// The times after which a TCP connection is given up.
struct ConnectionTimes {
  /// For each address of the server. Long enough for two repetitions of the SYN, which come after 1
  /// s and 3 s.
  Duration connect_timeout = std::chrono::seconds(4);
  /// Data that the far end has not acknowledged for this long is discarded together with the
  /// connection: an old command must not arrive when the network is repaired. Long enough for three
  /// repetitions, the first of them after 200 ms.
  Duration acknowledge_timeout = std::chrono::seconds(2);
  /// How soon it is noticed on an idle connection that the far end has disappeared without closing
  /// it. Whole seconds, at least 2.
  std::chrono::seconds idle_probe{15};
  friend bool operator==(const ConnectionTimes&, const ConnectionTimes&) = default;
};

/// How a Modbus TCP server is reached over TLS. Nothing of it is looked at here.
struct TlsPeer {
  std::string certificate;  ///< our own and those between it and its authority: a file in PEM
  std::string key;          ///< the name by which the signer knows our private key
  std::string authorities;  ///< who may have signed the server's: a file in PEM
  std::string crl;          ///< which of these are revoked: a file in PEM, or empty
  std::string signer;       ///< the socket of the signer
  std::string server_name;  ///< that the server's certificate must be for
  friend bool operator==(const TlsPeer&, const TlsPeer&) = default;
};

struct LineSettings {
  Framing framing = Framing::rtu;
  /// Set: a TCP connection in place of a serial line. Framing tcp always has one; with rtu and
  /// ascii a serial device server is behind it.
  std::optional<Endpoint> remote;
  ConnectionTimes connection;    ///< with `remote`
  std::optional<TlsPeer> tls{};  ///< with framing tcp; none: plain TCP
  std::string device;            ///< path, preferably below /dev/serial/by-id
  modbus::Baud baud{19200};
  modbus::CharacterFormat format;
  Rs485 rs485 = Rs485::off;
  /// With rs485 = kernel: whether RTS is high (true) or low while sending, and how long it is
  /// switched before and after. None: the driver's own setting, from the device tree.
  std::optional<bool> rs485_rts_on_send;
  std::optional<Duration> rs485_delay_before;
  std::optional<Duration> rs485_delay_after;
  /// True: the transceiver receives what it sends, and this echo is read and compared. None:
  /// learned from the line.
  std::optional<bool> echo{};
  /// True: bytes leave at the speed of the wire, so an answer that begins before its request has
  /// left is not accepted. None: depends on the LineKind.
  std::optional<bool> paced{};
  bool low_latency = true;

  /// The same port or server, by its name.
  [[nodiscard]] bool has_end_of(const LineSettings& other) const {
    return remote == other.remote && device == other.device;
  }
  friend bool operator==(const LineSettings&, const LineSettings&) = default;
};

/// Default `frame_slack` on a local port: adapters hold received bytes back for up to 16 ms.
inline constexpr Duration kAdapterSlack = std::chrono::milliseconds(20);

/// The same behind a serial device server: those on Wi-Fi or cellular networks pause for 60 ms and
/// more.
inline constexpr Duration kNetworkSlack = std::chrono::milliseconds(200);

struct BusSettings {
  std::string name;
  bool is_gone = false;  ///< a reload has removed it; its number is not used again
  LineSettings line;
  /// For addresses that no device is configured for.
  drive::DeviceTiming timing;
  std::optional<Duration> frame_gap;    ///< default: t3.5
  std::optional<Duration> frame_slack;  ///< default: kAdapterSlack, or kNetworkSlack
  /// Of a port that the gateway has not had open before. Default: default_listen_first().
  std::optional<Duration> listen_first;
  Duration turnaround = std::chrono::milliseconds(100);
  Duration settle{0};
  std::size_t queue = 2048;  ///< requests waiting at most, stops not counted
  bool coalesce = true;      ///< identical waiting reads are transmitted once
  unsigned burst = 8;        ///< after this many consecutive writes, one waiting read is sent
  /// How long a stop waits for the first byte of the response of a running transaction, from the
  /// end of its request.
  Duration stop_wait = std::chrono::milliseconds(100);
  /// A stop that finds no silence for this long on an open line is sent anyway. Default: 2 s, but
  /// at least least_stop_deadline().
  std::optional<Duration> stop_deadline;
  /// While there are requests to other devices, the probes of all offline devices together take at
  /// most this percentage of the time of the bus.
  unsigned probe_share = 5;
  std::size_t outstanding = 1;  ///< framing tcp: requests in flight at a time
  /// Framing tcp: true if a response must have the unit identifier of its request. False: the
  /// transaction identifier is enough; many servers answer as unit 1 or 255.
  bool check_unit = false;
  /// Framing tcp: false if the server does not return transaction identifiers. Then late answers
  /// are told apart as on a serial line: `outstanding` is 1, `check_unit` is true.
  bool check_transaction = true;
  /// Framing tcp: how long nothing is sent on a new connection.
  Duration connect_delay{0};
  /// Framing tcp: whether every unit is the one device of this bus. None: if its address is 255.
  std::optional<bool> one_device{};
  /// Framing tcp: a connection is replaced if this many requests on it were unanswered and nothing
  /// was received for 30 s meanwhile; 0: never.
  unsigned replace_after = 5;
  Duration reopen_min = std::chrono::milliseconds(100);
  Duration reopen_max = std::chrono::seconds(5);
  /// A physical adapter, or a device server behind tcp://, that received nothing for `hung_after`,
  /// while at least `hung_requests` requests were sent, is closed and opened again; 0: never. The
  /// time doubles with each reopening, up to `hung_max`, until something is received.
  Duration hung_after = std::chrono::seconds(30);
  unsigned hung_requests = 10;
  Duration hung_max = std::chrono::minutes(10);

  /// Do transaction identifiers tell whose a late answer is?
  [[nodiscard]] bool has_identifiers() const {
    return line.framing == Framing::tcp && check_transaction;
  }
  /// How long an RTU answer may pause in all, beyond the time that its bytes take. An answer of
  /// unknown length, or with a bad CRC, must be followed by this much silence.
  [[nodiscard]] Duration frame_slack_or_default() const {
    return frame_slack.value_or(line.remote ? kNetworkSlack : kAdapterSlack);
  }
};

/// The longest time for which one ordinary transaction can hold the bus: a frame of full length and
/// a short one, the longest wait for a response of its devices, and `settle`. Slow registers do not
/// count, nor do addresses without a device if there are devices.
Duration longest_transaction(const BusSettings& settings, std::span<const drive::Device> devices);

/// The longest time that a stop waits where it does not go at once: for the running transaction,
/// slow registers included, or the turnaround of a broadcast, and for silence.
Duration longest_stop_wait(const BusSettings& settings, std::vector<drive::Device> devices);

/// The longest time for which an answer to somebody who had the line before may still come: the
/// longest response timeout of ordinary registers and its quarantine.
Duration default_listen_first(const BusSettings& settings, std::span<const drive::Device> devices);

/// The time that the longest frame takes on a serial line, and a tenth more; 0 with framing tcp.
Duration longest_stream(const BusSettings& settings);

/// `stop_wait` plus longest_stream(): by then the answer to a running transaction, and the longest
/// frame that may be on the line, are over.
Duration least_stop_deadline(const BusSettings& settings);
Duration stop_deadline(const BusSettings& settings);

}  // namespace mbgate::bus

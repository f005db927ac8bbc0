// SPDX-License-Identifier: Apache-2.0
// All settings of the gateway. Names and meanings are those of conf/mbgate.toml.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bus/instant.hpp"
#include "bus/settings.hpp"
#include "drive/device.hpp"
#include "modbus/request.hpp"
#include "routing/access_rules.hpp"
#include "routing/client_address.hpp"
#include "routing/route.hpp"

namespace mbgate::gateway {

using bus::BusSettings;
using bus::Duration;
using bus::Instant;
using drive::BusId;
using routing::ListenerId;

/// A zero duration turns the timer off.
struct TcpSettings {
  Duration keepalive_idle = std::chrono::seconds(30);
  Duration keepalive_interval = std::chrono::seconds(10);
  unsigned keepalive_probes = 3;
  /// How long sent bytes may stay unacknowledged before the connection is given up. Linux gives up
  /// a silent client at the first unanswered probe after this time, too, and no longer counts the
  /// probes (tcp(7), TCP_USER_TIMEOUT): the default is the time that the three probes take.
  Duration user_timeout = std::chrono::seconds(60);
  unsigned backlog = 1024;
  friend bool operator==(const TcpSettings&, const TcpSettings&) = default;
};

/// Of the file of a private key. A question to mbgate-signer has room for it.
inline constexpr std::size_t kLongestKeyName = 255;

/// Who this end of TLS is, and whom it trusts (MB-TCP-Security v36). The machine does not look at
/// it.
struct TlsSettings {
  std::string name;
  std::string certificate{};  ///< PEM: its own, then those between it and the authority
  std::string key{};          ///< name of a file in the folder of mbgate-signer
  std::string authorities{};  ///< PEM: who signs the certificates of others
  std::string crl{};          ///< PEM: what is revoked; empty: nothing is known of that
  friend bool operator==(const TlsSettings&, const TlsSettings&) = default;
};

/// Clients of a listener with TLS that are not known yet.
struct HandshakeSettings {
  Duration timeout = std::chrono::seconds(10);  ///< from the connection to the end of the handshake
  Duration hello = std::chrono::seconds(2);     ///< from the connection to its ClientHello
  std::size_t at_a_time = 64;                   ///< handshakes under way
  std::size_t for_one_client = 8;               ///< of these, from one client address
  unsigned per_second = 100;                    ///< that begin; 0: any number
  unsigned per_second_for_one_client = 20;      ///< from one client address; 0: any number
  friend bool operator==(const HandshakeSettings&, const HandshakeSettings&) = default;
};

struct ListenerSettings {
  std::string name;
  bool is_gone = false;  ///< a reload has removed it; its number is not used again
  std::string address = "127.0.0.1";
  std::uint16_t port = 502;  ///< 0: the kernel chooses
  bool freebind = false;     ///< listens even if the address does not exist yet
  std::size_t max_connections = 256;
  std::size_t max_connections_per_address = 64;
  unsigned max_connects_per_second = 100;   ///< from one address; 0: any number
  unsigned max_requests_per_second = 5000;  ///< from one address; 0: any number
  std::size_t pipeline = 64;                ///< requests of a connection that buses may have
  bool ordered = false;                     ///< responses in the order of the requests
  Duration give_up{0};                      ///< the clients' own timeout; 0: not known
  bool one_at_a_time = false;               ///< a new request replaces the unanswered one
  Duration idle_timeout{0};                 ///< 0: never
  Duration frame_timeout = std::chrono::seconds(10);
  routing::NetworkList allow;     ///< empty: everyone
  routing::ClientList read_only;  ///< clients that may not write
  routing::ClientList keep;       ///< clients whose connection is never closed in favour of another
  /// Limits and turns count clients by the names of their certificates instead of their addresses.
  bool counts_certificates = false;
  std::optional<BusId> bus;  ///< set: a transparent listener of this bus
  bool broadcast = false;    ///< transparent listeners: unit 0 is sent to the bus
  routing::BroadcastReply broadcast_reply = routing::BroadcastReply::echo;
  bool broadcast_mixed = false;  ///< also where not all devices have the register, and alike
  TcpSettings tcp;
  std::optional<std::size_t> tls;  ///< index in the same Settings; none: without encryption
  HandshakeSettings handshakes;
};

/// Connections to the HTTP interface that follow nothing: so many at a time over the Unix socket,
/// and as many over TCP.
inline constexpr std::size_t kHttpConnections = 64;

/// Who reads the HTTP interface over TCP, beside the Unix socket. The machine does not look at it.
struct HttpSettings {
  std::vector<routing::ListenAddress> listen{};
  routing::NetworkList allow = routing::loopback_networks();
  std::vector<std::string> hosts{};  ///< names of this machine in URLs, in small letters
  std::size_t max_streams = 64;      ///< that are read at a time, over all sockets; 1 at least
  bool client_metrics = false;       ///< metrics name the addresses of clients
  friend bool operator==(const HttpSettings&, const HttpSettings&) = default;
};

enum class WriterRule : std::uint8_t {
  any,
  first,  ///< the client that wrote last owns writing for `writer_hold`
  listed  ///< the clients in `writers` and no others
};

/// Who may write to a device, and the failsafe writes that it gets when the client that counts has
/// gone.
struct DeviceGuard {
  WriterRule writer = WriterRule::any;
  routing::ClientList writers;
  Duration writer_hold = std::chrono::seconds(5);
  /// Whose leaving and silence counts for the failsafe writes; empty: that of the client that wrote
  /// to the device last.
  routing::ClientList failsafe_clients;
  /// Failsafe writes, with the function code that the device takes.
  std::vector<modbus::Request> failsafe;
  Duration quiet{0};  ///< 0: silence alone is no reason
  /// A client that counts has gone when it has asked the device nothing for so long.
  Duration failsafe_grace = std::chrono::seconds(1);
  bool failsafe_on_exit = false;  ///< also when the gateway stops, if clients have written
};

/// Clients in the network get `weight` turns where others get one.
struct ClientWeight {
  routing::Network network;
  unsigned weight = 1;
  friend bool operator==(const ClientWeight&, const ClientWeight&) = default;
};

/// The number of a listener, bus or device is its index here; a reload does not change it
/// (numbered_after() in settings/settings_snapshot).
struct Settings {
  /// The identifier of the status unit on every listener; none turns it off.
  std::optional<std::uint8_t> status_unit = 255;
  bool lock_memory = false;  ///< nothing of the process is ever swapped out
  bool audit = false;        ///< the journal is told of every write that is accepted
  /// Path of the Unix socket of the HTTP interface; empty: there is none.
  std::string control_socket = "/run/mbgate/control";
  HttpSettings http{};
  /// Path of the Unix socket of mbgate-signer, which holds the private keys.
  std::string signer = "/run/mbgate-signer/socket";
  /// Kernel timers fire late: the driver wakes so long before an instant and busy-waits for it.
  Duration wake_early = std::chrono::microseconds(40);
  std::vector<TlsSettings> tls{};
  std::vector<ListenerSettings> listeners;
  std::vector<BusSettings> buses;
  std::vector<drive::Device> devices;
  /// By device number; devices beyond the end have no rules of their own.
  std::vector<DeviceGuard> guards;
  std::vector<routing::Route> routes;
  std::vector<routing::AccessRule> rules{};  ///< none: nobody is denied anything by a rule
  std::vector<ClientWeight> weights;         ///< the first that fits counts; others have weight 1
  /// Numbers in the order of the configuration file; none: in the order of the numbers.
  struct WrittenOrder {
    std::vector<std::size_t> buses;
    std::vector<std::size_t> devices;
  };
  std::optional<WrittenOrder> written_order{};

  [[nodiscard]] const ListenerSettings& listener(ListenerId id) const {
    return listeners[static_cast<std::size_t>(id)];
  }
  /// Nothing says who may connect to the listener.
  [[nodiscard]] bool is_open_to_all(const ListenerSettings& listener) const {
    return listener.allow.empty() && rules.empty();
  }
  [[nodiscard]] std::vector<drive::Device> devices_on(BusId bus) const;
  /// Of the device at this address; empty if there is none.
  [[nodiscard]] std::string device_name(BusId bus, std::uint8_t address) const;
  /// Those that are not removed, in the order of the configuration file.
  [[nodiscard]] std::vector<BusId> written_buses() const;
  struct WrittenDevice {
    const drive::Device* device;
    std::size_t bus;  ///< its place among the buses
  };
  [[nodiscard]] std::vector<WrittenDevice> written_devices() const;
  [[nodiscard]] const BusSettings& bus(BusId id) const {
    return buses[static_cast<std::size_t>(id)];
  }
};

/// How many of these listeners or buses are there: entries that a reload has emptied are none.
[[nodiscard]] std::size_t count_there(const auto& all) {
  return static_cast<std::size_t>(
      std::ranges::count_if(all, [](const auto& it) { return !it.is_gone; }));
}

}  // namespace mbgate::gateway

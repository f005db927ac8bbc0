// SPDX-License-Identifier: Apache-2.0
// The events that an operator may want to know about. They are plain values: report/event_text
// words them, and only app/journal writes them to the journal.
#pragma once

#include <bitset>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "bus/bus.hpp"
#include "gateway/client.hpp"
#include "gateway/settings.hpp"
#include "modbus/mbap.hpp"

namespace mbgate::gateway {

// The client and the contents of a request, with all that the journal needs so that somebody can be
// found afterwards.

/// A client, and what its certificate says of it.
struct Asker {
  ListenerId listener{};
  routing::ClientAddress address;
  routing::ClientRole role{};
};

/// A request of a client, as it was sent.
struct Asked : Asker {
  std::uint8_t unit = 0;
  std::vector<std::uint8_t> pdu{};
};

inline Asker asker_of(const ClientInfo& client) {
  return {client.listener, client.address, client.role};
}
inline Asked asked_of(const ClientInfo& client, const modbus::MbapAdu& adu) {
  const modbus::Bytes pdu = adu.pdu.bytes();
  return {asker_of(client), adu.header.unit, {pdu.begin(), pdu.end()}};
}

enum class RefusalReason : std::uint8_t {
  not_allowed,   ///< not in the listener's allow list
  full,          ///< max_connections reached, and no other connection may be closed for this one
  stopping,      ///< the gateway is stopping
  no_rule,       ///< no access rule can permit anything to its address
  address_full,  ///< max_connections_per_address reached, and none of these is idle
  too_often      ///< more than max_connects_per_second
};

struct BusOpened {
  BusId bus;
};
struct BusLost {
  BusId bus;
};
/// Nothing at all is received from the adapter of a bus: it is closed and opened again.
struct AdapterSilent {
  BusId bus;
  Duration silence;
  unsigned requests;  ///< sent in this time
};
struct ClientRefused : Asker {
  RefusalReason reason;
};
/// Closed to make room for a new connection.
struct ClientDisplaced : Asker {
  RefusalReason limit;  ///< full or address_full
};
/// It sends more than max_requests_per_second: what is beyond gets 06. Reported once a minute for
/// each client.
struct ClientOverRate : Asker {};
/// An impossible length in an MBAP header: the framing of the stream is lost.
struct ClientFramingLost : Asker {
  std::uint16_t length;
  std::string_view sends{};  ///< modbus::other_protocol()
};
/// Bytes that look like an RTU frame came in on the TCP port.
struct ClientSpeaksRtu : Asker {};
/// A partial ADU older than frame_timeout.
struct ClientFrameTimedOut : Asker {};
/// A fault of the line itself was noticed.
struct LineNews {
  BusId bus;
  bus::LineFault fault;
};
/// So many bytes without a silence that nothing can be transmitted.
struct LineNeverSilent {
  BusId bus;
};

/// Communication registers of a device were written (allow_reconfigure): it may be reached
/// differently from now on.
struct Reconfigured {
  BusId bus;
  std::uint8_t address;
  routing::ClientAddress client;
  bool by_value = false;  ///< not these registers, but a value that the profile guards
};
/// A write of several transactions ended after some of them. Addresses are the device's.
struct WriteEndedEarly {
  BusId bus;
  std::uint8_t address;
  modbus::Table table;
  std::uint16_t first;
  std::uint16_t failed;  ///< the first one that was not written, as far as is known
  std::uint32_t end;     ///< behind the last one that should have been
};
/// verify_word_order: the drive's own setting is not the configured one; no values are written to
/// it.
struct WordOrderDiffers {
  BusId bus;
  std::uint8_t address;
};

/// The bus has noticed something about the device at an address.
struct DeviceNews {
  BusId bus;
  bus::DeviceNotice notice;
};
/// The quality of the answers of a device, or of a line, has changed.
struct QualityNews {
  BusId bus;
  bus::QualityNotice notice;
};
enum class FailsafeReason : std::uint8_t {
  gone,    ///< the last connection of the client that counts has ended
  silent,  ///< that client is silent
  exit     ///< the gateway stops
};
enum class FailsafeOutcome : std::uint8_t {
  acknowledged,  ///< all of them
  waits,         ///< not all of them, for now: they stay due
  client_back,   ///< not all of them, and now the client that counts asks the device again
  given_up,      ///< not all of them before the gateway stopped
  device_gone    ///< new settings have no such device there any more, and clients wrote to it
};
/// What became of a device's failsafe writes.
struct FailsafeNews {
  BusId bus;
  std::uint8_t address;
  FailsafeReason reason;
  FailsafeOutcome outcome;
};
/// A client asks for a unit that has no route. Reported once for each client.
struct UnitNotRouted : Asker {
  std::uint8_t unit;
  std::bitset<256> routed;  ///< the units that have a route on this listener
};
/// Why a request was not done, and how many of the same client and kind were not reported before.
struct Denied : Asked {
  std::string by{};  ///< "denied by rule ...", "denied by read_only of listener plant"
  std::uint64_t left_out = 0;
};
/// A read that its client may not make. Reported once a minute for each client.
struct ReadDenied : Denied {};
/// The same of a write.
struct WriteDenied : Denied {};
/// The same of a stop; ten times a minute for each client.
struct StopDenied : Denied {};
/// A write or a stop was accepted (`audit = true`): what becomes of it is not known yet. Each is
/// reported.
struct WriteAccepted : Asked {
  bool is_stop = false;
  /// Where all of it goes; nothing: to several.
  struct Target {
    BusId bus;
    std::uint8_t address;
    friend bool operator==(const Target&, const Target&) = default;
  };
  std::optional<Target> target{};
};
/// A broadcast was accepted that is not for all devices of its buses.
struct BroadcastLeavesOut : Asked {
  bool is_stop = false;
  std::string devices{};  ///< their names, with commas
};
/// A client has set all counters to 0 (08/0A at the status unit).
struct CountersCleared : Asked {
  std::uint64_t left_out = 0;
};
/// A client has shown a certificate, and was let in.
struct ClientLoggedIn : Asker {
  std::uint64_t left_out = 0;
};

using Event =
    std::variant<BusOpened, BusLost, AdapterSilent, ClientRefused, ClientDisplaced, ClientOverRate,
                 ClientFramingLost, ClientSpeaksRtu, ClientFrameTimedOut, LineNews, LineNeverSilent,
                 Reconfigured, WriteEndedEarly, WordOrderDiffers, DeviceNews, QualityNews,
                 FailsafeNews, UnitNotRouted, ReadDenied, WriteDenied, StopDenied, WriteAccepted,
                 BroadcastLeavesOut, CountersCleared, ClientLoggedIn>;

}  // namespace mbgate::gateway

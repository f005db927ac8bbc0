// SPDX-License-Identifier: Apache-2.0
// What an operator may want to know. Events are plain values; only app/log makes lines of them.
#pragma once

#include <bitset>
#include <cstdint>
#include <string>
#include <variant>

#include "bus/bus.hpp"
#include "gateway/settings.hpp"

namespace mbgate::gateway {

enum class RefusalReason : std::uint8_t {
  not_allowed,  ///< not in the listener's allow list
  full,         ///< max_connections reached and no idle connection could make room
  stopping      ///< the gateway is stopping
};

struct BusOpened {
  BusId bus;
};
struct BusLost {
  BusId bus;
};
/// Nothing at all is heard from the adapter of a bus: it is closed and opened again.
struct AdapterSilent {
  BusId bus;
  Duration silence;
  unsigned requests;  ///< that left in this time
};
/// Nothing has come from a connection for long, though requests went out: another one takes its
/// place.
struct ConnectionReplaced {
  BusId bus;
};
struct ClientRefused {
  ListenerId listener;
  routing::ClientAddress address;
  RefusalReason reason;
};
/// Closed to make room for a newcomer.
struct ClientDisplaced {
  ListenerId listener;
  routing::ClientAddress address;
};
/// An MBAP length that cannot be: the stream cannot be followed any further.
struct ClientFramingLost {
  ListenerId listener;
  routing::ClientAddress address;
  std::uint16_t length;
};
/// Bytes that look like an RTU frame came in on the TCP port.
struct ClientSpeaksRtu {
  ListenerId listener;
  routing::ClientAddress address;
};
/// A partial ADU older than frame_timeout.
struct ClientFrameTimedOut {
  ListenerId listener;
  routing::ClientAddress address;
};
/// Something was noticed of a line itself.
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
/// verify_word_order: the drive's own setting is another one; values are not written to it.
struct WordOrderDiffers {
  BusId bus;
  std::uint8_t address;
};

/// The bus has learned something of the device at an address.
struct DeviceNews {
  BusId bus;
  bus::DeviceNotice notice;
};
/// What the answers of a device, or of a line, are like has changed.
struct QualityNews {
  BusId bus;
  bus::QualityNotice notice;
};
enum class FailsafeReason : std::uint8_t {
  gone,    ///< the last client that might write to the device
  silent,  ///< all of them
  exit     ///< the gateway stops
};
enum class FailsafeOutcome : std::uint8_t {
  sent,         ///< all were transmitted
  waits,        ///< not all could be: they stay due
  client_back,  ///< not all were, and now a client asks again
  given_up,     ///< not all were before the gateway stopped
  device_gone   ///< not all were before the device left the configuration
};
/// What became of a device's failsafe writes.
struct FailsafeNews {
  BusId bus;
  std::uint8_t address;
  FailsafeReason reason;
  FailsafeOutcome outcome;
};
/// A client asks for a unit that leads nowhere. Said once a client.
struct UnitNotRouted {
  ListenerId listener;
  routing::ClientAddress address;
  std::uint8_t unit;
  std::bitset<256> routed;  ///< the units that lead somewhere, on this listener
};

using Event = std::variant<BusOpened, BusLost, AdapterSilent, ConnectionReplaced, ClientRefused,
                           ClientDisplaced, ClientFramingLost, ClientSpeaksRtu, ClientFrameTimedOut,
                           LineNews, LineNeverSilent, Reconfigured, WriteEndedEarly,
                           WordOrderDiffers, DeviceNews, QualityNews, FailsafeNews, UnitNotRouted>;

/// One line for the journal. The settings give the names.
std::string to_text(const Event& event, const Settings& settings);

}  // namespace mbgate::gateway

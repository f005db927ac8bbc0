// SPDX-License-Identifier: Apache-2.0
// What an operator may want to know. Events are plain values; only app/log makes lines of them.
#pragma once

#include <cstdint>
#include <string>
#include <variant>

#include "bus/bus.hpp"
#include "gateway/settings.hpp"

namespace mbgate::gateway {

/// A TCP connection; the driver numbers them and uses no number twice.
enum class ClientId : std::uint64_t {};

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
/// The echo of our own transmission differed: a collision, or a transceiver without echo.
struct EchoMismatch {
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
/// The last client that might write to the device has gone, or all were silent: its failsafe writes
/// are on their way.
struct FailsafeSent {
  BusId bus;
  std::uint8_t address;
  bool silence;  ///< they are connected, but silent
};

using Event = std::variant<BusOpened, BusLost, ClientRefused, ClientDisplaced, ClientFramingLost,
                           ClientSpeaksRtu, ClientFrameTimedOut, EchoMismatch, Reconfigured,
                           WriteEndedEarly, WordOrderDiffers, DeviceNews, FailsafeSent>;

/// One line for the journal. The settings give the names.
std::string to_text(const Event& event, const Settings& settings);

}  // namespace mbgate::gateway

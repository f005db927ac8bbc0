// SPDX-License-Identifier: Apache-2.0
// A route: which unit identifier of a client leads to which device, and which requests it lets
// through.
#pragma once

#include <bitset>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "drive/device.hpp"
#include "modbus/pdu.hpp"
#include "modbus/request.hpp"

namespace mbgate::routing {

using drive::BusId;
using modbus::Duration;

/// The number of a listener: its index in the settings.
enum class ListenerId : std::uint32_t {};

enum class Access : std::uint8_t { read_only, read_write };

/// What the client of a broadcast gets once every bus has transmitted it.
enum class BroadcastReply : std::uint8_t { echo, none };

/// Client addresses `from` .. `from + count - 1` of one table become device addresses from `to` on,
/// possibly of another table of the same width.
struct AddressWindow {
  modbus::Table table = modbus::Table::holding_registers;
  std::uint16_t from = 0;
  std::uint32_t count = 0;  ///< 1 to 65536; neither side passes 65536
  modbus::Table to_table = modbus::Table::holding_registers;
  std::uint16_t to = 0;
  friend bool operator==(const AddressWindow&, const AddressWindow&) = default;
};

/// The function codes that a route lets through. 08/01 and 08/04, and on ASCII lines 08/03, silence
/// a device and pass only where they are named (Application Protocol V1.1b3, 6.8.1).
struct FunctionRules {
  std::bitset<128> allowed;             ///< 8: without the three below, which pass by themselves
  bool restart_communications = false;  ///< 08/01
  bool force_listen_only = false;       ///< 08/04
  /// 08/03: on an ASCII line another end of a frame would silence the device.
  bool change_delimiter = false;
  /// The function codes of which anything passes.
  [[nodiscard]] std::bitset<128> codes() const;
  /// Functions 1 to 127, and 08/03.
  static FunctionRules all();
  /// Those whose addresses a window can rewrite: 01-06, 15, 16, 22, 23, 24.
  static FunctionRules rewritable();
  friend bool operator==(const FunctionRules&, const FunctionRules&) = default;
};

struct Route {
  std::optional<ListenerId> listener;  ///< none: every routed listener
  std::uint8_t first_unit = 0;
  std::uint8_t last_unit = 0;
  /// One bus; for a broadcast route one or more.
  std::vector<BusId> buses;
  /// The bus address of first_unit; the others follow in order. 0 for a broadcast route.
  std::uint8_t first_address = 0;
  /// The index of the device that the route names; none for a bus and address.
  std::optional<std::size_t> device;
  /// The word order that the client wants to see; none: nothing is exchanged.
  std::optional<drive::WordOrder> word_order;
  std::vector<AddressWindow> windows;  ///< none: everything passes as it is
  Access access = Access::read_write;
  FunctionRules functions = FunctionRules::all();
  bool functions_named = false;  ///< in the configuration; else the drive's own functions count too
  std::optional<Duration> deadline;  ///< default by read and write: see Gateway
  BroadcastReply broadcast_reply = BroadcastReply::echo;
  /// Of a broadcast: also where a device has no such register, or another meaning for it.
  bool broadcast_mixed = false;

  /// Is it a broadcast route? One that names a device is not, whatever its unit: some clients can
  /// only use unit 0.
  [[nodiscard]] bool is_broadcast() const {
    return !device && first_unit == 0 && first_address == 0;
  }
  /// The bus address that the unit stands for, unless the route is a broadcast.
  [[nodiscard]] std::uint8_t address_of(std::uint8_t unit) const {
    return static_cast<std::uint8_t>(first_address + (unit - first_unit));
  }
  /// Does the route let any function through that may set something going? Unknown ones may;
  /// diagnostics and identification (08, 43) do not.
  [[nodiscard]] bool may_write() const;
  friend bool operator==(const Route&, const Route&) = default;
};

// Rewriting of table addresses: what a client sees at `from` lies in the device at `to`, possibly
// in another table.

/// The request as the device must see it; without windows as it is. Each range that it names must
/// lie wholly in one window (else 02); what the other table cannot do, such as writing input
/// registers, is 01. Requests that name no table pass unchanged; the functions of the route decide
/// whether they may.
Result<modbus::Request, modbus::ExceptionCode> through_windows(
    std::span<const AddressWindow> windows, const modbus::Request& request);

// A route with what it leads to: the device, or the devices that hear a broadcast.

/// The devices of one bus that a broadcast is meant for. None: no devices are configured, and the
/// broadcast is sent in the standard form.
struct BusDevices {
  BusId bus;
  std::vector<const drive::Device*> devices;
};

struct ResolvedRoute {
  Route route;
  const drive::Device* device = nullptr;       ///< set: the rules of its profile apply
  std::vector<BusDevices> devices_of_buses{};  ///< of a broadcast
  /// Set: only this form is sent, because the client has addressed the broadcast address of a
  /// drive's own form.
  std::optional<drive::BroadcastForm> only_form{};
  /// Set: every unit of the bus is the one device that has this address.
  std::optional<std::uint8_t> one_address{};

  [[nodiscard]] bool is_broadcast() const { return !devices_of_buses.empty(); }
  /// Does the unit, which is one of the route's, lead to the device?
  [[nodiscard]] bool leads_to(const drive::Device& server, std::uint8_t unit) const;
};

// Decides for each request whether its client may make it on this route; a denied one gets
// exception 01.

/// What a client may do, by its address on its listener.
struct ClientRights {
  bool read_only = false;
};

/// What does not allow a request.
enum class Denial : std::uint8_t { functions, read_only_client, read_only_route, no_broadcast };

/// Function codes, sub-functions of 08 (21 never), read-only routes and clients; broadcasts are 05,
/// 06, 15, 16 only. Nothing if it is allowed.
[[nodiscard]] std::optional<Denial> denial_of(const ResolvedRoute& resolved, ClientRights rights,
                                              const modbus::Pdu& pdu);

}  // namespace mbgate::routing

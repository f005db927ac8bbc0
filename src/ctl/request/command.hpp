// SPDX-License-Identifier: Apache-2.0
// A command of the operator as plain values: which server, what to read, what to write.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "ctl/request/value_text.hpp"
#include "ctl/serial/serial_port.hpp"
#include "modbus/pdu.hpp"
#include "modbus/request.hpp"
#include "modbus/result.hpp"

namespace mbgate::ctl {

using modbus::Table;

/// Who we are to a server over TLS, and whom we take it for.
struct TlsIdentity {
  std::filesystem::path certificate;  ///< ours, in PEM, with those between it and its authority
  std::filesystem::path key;
  std::filesystem::path authorities;  ///< who may have signed the server's certificate
  std::string server_name;            ///< that it is for; empty: the host that is connected to
};

/// A Modbus TCP server and a unit identifier.
struct Target {
  std::string host = "127.0.0.1";
  std::uint16_t port = 502;
  std::uint8_t unit = 1;
  /// For connecting, and again for the response.
  std::chrono::nanoseconds timeout = std::chrono::seconds(5);
  std::optional<TlsIdentity> tls{};  ///< none: plain TCP
};

/// Where values are and what type they have.
struct Place {
  Table table = Table::holding_registers;
  std::uint16_t address = 0;
  ValueType type = ValueType::u16;
  drive::WordOrder order = drive::WordOrder::big;
};

struct ReadCommand {
  Target target;
  Place place;
  std::size_t count = 1;  ///< values, not registers; of a text, its registers
  bool quiet = false;     ///< print the plain values only
  bool json = false;      ///< one JSON object a read
  std::optional<std::chrono::nanoseconds> every;  ///< from start to start; none: read once
  std::optional<std::size_t> times;               ///< with `every`; none: until interrupted
};

struct WriteCommand {
  Target target;
  Place place;
  std::vector<std::uint64_t> values;
  bool multiple = false;  ///< functions 15 and 16 even for a single coil or register
  bool quiet = false;     ///< print nothing on success
  bool json = false;
};

/// Shows what is known of a kind of drive; no server is contacted.
struct ProfileCommand {
  std::string which;  ///< a name, or a file (with a '/' or ".toml"); empty: the list of all
  std::optional<std::filesystem::path> folder;  ///< the only one to look in
  bool json = false;
};

/// A serial port to scan without a gateway, and how.
struct PortSweep {
  std::string device;
  std::vector<LineMode> modes;    ///< in the order in which they are tried
  std::chrono::nanoseconds wait;  ///< for an answer, after the request was sent
  bool all_modes = false;         ///< not only until one has an answer
};

/// Finds out which drives are at the units of a bus.
struct ScanCommand {
  Target target;                  ///< its unit is not used
  std::optional<PortSweep> port;  ///< asked instead of the target
  std::vector<std::uint8_t> units;
  std::optional<std::filesystem::path> folder;  ///< the only one to look for profiles in
  std::string bus = "line-a";                   ///< its name in the configuration
  std::optional<std::filesystem::path> config;  ///< none: standard output
  bool json = false;
  bool show_progress = false;  ///< on standard error
};

/// Says what is wrong with the files of a configuration; no port is opened.
struct CheckCommand {
  std::filesystem::path config = "/etc/mbgate/mbgate.toml";
  std::optional<std::filesystem::path> folder;  ///< the only one to look for profiles in
};

/// Does again what a recorded gateway did; no port is opened.
struct ReplayCommand {
  std::filesystem::path recording;
  std::optional<std::filesystem::path> folder;  ///< goes before the one that the recording names
};

/// A serial port to examine that no configuration describes.
struct ExaminedPort {
  std::string device;
  LineMode mode;
  std::chrono::nanoseconds timeout;  ///< an answer that comes later is too late
};

/// Says what is wrong with a serial line that no gateway holds. Only reads are sent.
struct DoctorCommand {
  std::optional<ExaminedPort> port;  ///< none: a bus of the configuration
  std::string bus;                   ///< empty: the only one there is
  std::filesystem::path config = "/etc/mbgate/mbgate.toml";
  std::optional<std::filesystem::path> folder;  ///< the only one to look for profiles in
  std::vector<std::uint8_t> units;              ///< to ask; none: those that are configured
  std::uint16_t holding_register = 0;           ///< what is read
  std::size_t requests = 20;                    ///< to each of them
  std::chrono::nanoseconds listen = std::chrono::seconds(2);  ///< to the idle line
  bool json = false;
};

inline constexpr const char* kControlSocket = "/run/mbgate/control";

/// Shows the state of a running mbgated.
struct StatusCommand {
  std::string socket = kControlSocket;
  bool json = false;                              ///< one JSON object a status
  std::optional<std::chrono::nanoseconds> every;  ///< from start to start; none: show it once
  std::optional<std::size_t> times;               ///< with `every`; none: until interrupted
  bool on_terminal = false;                       ///< standard output is one
};

/// Has a running mbgated read its configuration again.
struct ReloadCommand {
  std::string socket = kControlSocket;
};

/// Has all counters of a running mbgated begin anew.
struct ClearCountersCommand {
  std::string socket = kControlSocket;
};

/// Prints what a running mbgated says, as it says it.
struct EventsCommand {
  std::string socket = kControlSocket;
  bool json = false;  ///< one object a line
};

/// Which requests and frames are traced; what is empty or nothing lets all through.
struct TraceFilter {
  std::string bus;
  std::string device;
  std::string client;                    ///< an IP address
  std::optional<std::uint8_t> function;  ///< of the request
  bool only_failed = false;
};

/// Prints what goes through a running mbgated, from the clients to the wire and back.
struct TraceCommand {
  std::string socket = kControlSocket;
  TraceFilter filter;
  bool json = false;                 ///< one object a line
  bool quiet = false;                ///< no text
  std::string pcapng;                ///< a file; "-": standard output, without text; empty: none
  std::optional<std::size_t> times;  ///< records; none: until interrupted
};

using Command = std::variant<ReadCommand, WriteCommand, ProfileCommand, ScanCommand, CheckCommand,
                             DoctorCommand, ReplayCommand, StatusCommand, ReloadCommand,
                             ClearCountersCommand, EventsCommand, TraceCommand>;

/// The request for the command: 01-04; 05 and 06 for one coil or register; else 15 and 16, so that
/// the registers of a value are never written one by one. The error is a full sentence.
Result<modbus::Request, std::string> make_request(const ReadCommand& command);
Result<modbus::Request, std::string> make_request(const WriteCommand& command);

/// The values in the normal response to a read.
std::vector<std::uint64_t> response_values(const ReadCommand& command, const modbus::Pdu& response);

}  // namespace mbgate::ctl

// SPDX-License-Identifier: Apache-2.0
// What the operator asks for, as plain values: whom to ask, what to read, what to write.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "ctl/request/value.hpp"
#include "modbus/request.hpp"

namespace mbgate::ctl {

using modbus::Table;

/// A Modbus TCP server and the unit behind it.
struct Target {
  std::string host = "127.0.0.1";
  std::uint16_t port = 502;
  std::uint8_t unit = 1;
  /// For the connection, and again for the answer.
  std::chrono::nanoseconds timeout = std::chrono::seconds(5);
};

/// Where values lie and how they are to be understood.
struct Place {
  Table table = Table::holding_registers;
  std::uint16_t address = 0;
  ValueType type = ValueType::u16;
  drive::WordOrder order = drive::WordOrder::big;
};

struct ReadCommand {
  Target target;
  Place place;
  std::size_t count = 1;  ///< values, not registers
  bool quiet = false;     ///< print the plain values only
};

struct WriteCommand {
  Target target;
  Place place;
  std::vector<std::uint32_t> values;
  bool multiple = false;  ///< functions 15 and 16 even for a single coil or register
  bool quiet = false;     ///< print nothing on success
};

/// Shows what is known of a kind of drive; nobody is asked.
struct ProfileCommand {
  std::string which;  ///< a name, or a file (with a '/' or ".toml"); empty: the list of all
  std::optional<std::filesystem::path> folder;  ///< the only one to look in
  bool json = false;
};

/// Asks the units of a bus what they are.
struct ScanCommand {
  Target target;  ///< its unit means nothing here
  std::vector<std::uint8_t> units;
  std::optional<std::filesystem::path> folder;  ///< the only one to look for profiles in
  std::string bus = "line-a";                   ///< its name in the configuration
  std::optional<std::filesystem::path> config;  ///< standard output if there is none
  bool show_progress = false;                   ///< on the stream of errors
};

using Command = std::variant<ReadCommand, WriteCommand, ProfileCommand, ScanCommand>;

/// The request that the command stands for: 01-04; 05 and 06 for one coil or register; else 15 and
/// 16, so that the registers of a 32-bit value are never written one by one. The error is a whole
/// sentence.
Result<modbus::Request, std::string> make_request(const ReadCommand& command);
Result<modbus::Request, std::string> make_request(const WriteCommand& command);

/// The values in the normal response to a read.
std::vector<std::uint32_t> response_values(const ReadCommand& command, const modbus::Pdu& response);

}  // namespace mbgate::ctl

// SPDX-License-Identifier: Apache-2.0
// The connection to a server, as long as several requests use it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "ctl/request/command.hpp"
#include "ctl/request/modbus_client.hpp"

namespace mbgate::ctl {

/// Why a command was not carried out.
struct Failure {
  int status;  ///< of the program
  std::string text;
  std::optional<std::uint8_t> exception{};  ///< its code, if one came
};

class Connection {
 public:
  explicit Connection(Target target) : target_(std::move(target)) {}

  /// The normal response. Connects before the first request, and again after the connection was
  /// lost or a response did not come.
  Result<modbus::Pdu, Failure> ask(const modbus::Request& request);

 private:
  Target target_;
  std::optional<ModbusClient> client_;
};

}  // namespace mbgate::ctl

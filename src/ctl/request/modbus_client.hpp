// SPDX-License-Identifier: Apache-2.0
// A Modbus TCP client for one request at a time, over libmodbus. Requests and responses pass as raw
// bytes: libmodbus' own calls hide the number of an exception that the standard does not define,
// and drives have such exceptions (0x11 to 0x13).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "ctl/request/command.hpp"
#include "ctl/tls/handshake.hpp"
#include "modbus/pdu.hpp"
#include "modbus/request.hpp"
#include "modbus/result.hpp"

struct _modbus;  // libmodbus' modbus_t

namespace mbgate::ctl {

class ModbusClient {
 public:
  /// Connects within the timeout of the target. The error is a full sentence that names host and
  /// port.
  static Result<ModbusClient, std::string> connect(const Target& target);

  /// Sends the request and waits for its response: normal, or an exception. It is an error if the
  /// response does not match the request or does not come within the timeout.
  Result<modbus::Pdu, std::string> ask(const modbus::Request& request);

  /// Between two requests: is the connection of no more use, because the server has closed it or
  /// has sent something unasked?
  [[nodiscard]] bool is_lost() const;

 private:
  struct Free {
    void operator()(_modbus* context) const;
  };
  using Context = std::unique_ptr<_modbus, Free>;
  ModbusClient(Target target, std::unique_ptr<TlsTunnel> tunnel, Context context);
  [[nodiscard]] std::string failure(int error, const modbus::Request& request) const;

  Target target_;
  std::unique_ptr<TlsTunnel> tunnel_;  ///< none: plain TCP; it ends after the context has
  Context context_;
};

/// Why a command was not carried out.
struct Failure {
  int status;  ///< of the program
  std::string text;
  std::optional<std::uint8_t> exception{};  ///< its code, if one came
};

/// The connection to a server, as long as several requests use it.
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

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

  /// Connects within the timeout of the target, unless it is connected and the server has neither
  /// closed the connection nor sent something unasked. Why not, or nothing: a full sentence that
  /// names host and port.
  std::optional<std::string> open();
  /// Once it is open: sends the request and waits for its response, normal or an exception. It is
  /// an error if the response does not match the request or does not come within the timeout; the
  /// connection is closed then, because the response may still come, and must not be taken for the
  /// next one.
  Result<modbus::Pdu, std::string> exchange(const modbus::Request& request);
  /// Opens it, and gets the normal response.
  Result<modbus::Pdu, Failure> ask(const modbus::Request& request);

 private:
  struct Free {
    void operator()(_modbus* context) const;
  };
  using Context = std::unique_ptr<_modbus, Free>;

  Result<modbus::Pdu, std::string> receive(const modbus::Request& request);
  [[nodiscard]] std::string failure(int error) const;
  void close();

  Target target_;
  std::unique_ptr<TlsTunnel> tunnel_;  ///< none: plain TCP; it ends after the context has
  Context context_;                    ///< none: it is not connected
};

}  // namespace mbgate::ctl

// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/connection.hpp"

#include "ctl/request/carry_out.hpp"

namespace mbgate::ctl {

Result<modbus::Pdu, Failure> Connection::ask(const modbus::Request& request) {
  if (client_ && client_->is_lost()) {
    client_.reset();
  }
  if (!client_) {
    auto client = ModbusClient::connect(target_);
    if (!client) {
      return Failure{kExitNotDone, client.error()};
    }
    client_.emplace(*std::move(client));
  }
  const auto response = client_->ask(request);
  if (!response) {
    client_.reset();  // the response may still come, and must not be taken for the next one
    return Failure{kExitNotDone, response.error()};
  }
  if (response->is_exception()) {
    const std::uint8_t code = response->bytes()[1];
    return Failure{
        kExitNotDone,
        "unit " + std::to_string(target_.unit) + ": " + explain_exception(code, !request.is_read()),
        code};
  }
  return *response;
}

}  // namespace mbgate::ctl

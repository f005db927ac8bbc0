// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/connection.hpp"

#include "ctl/request/carry_out.hpp"
#include "ctl/tls/certificate_role.hpp"
#include "modbus/codes.hpp"

namespace mbgate::ctl {
namespace {

/// What a gateway over TLS judged by, if it may be that it does not allow the request.
std::string role_hint(const Target& target, std::uint8_t code) {
  if (!target.tls || code != static_cast<std::uint8_t>(modbus::ExceptionCode::illegal_function)) {
    return {};
  }
  const std::string file = target.tls->certificate.string();
  return "; the role in " + file + " is " + role_in_file(file);
}

}  // namespace

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
    return Failure{kExitNotDone,
                   "unit " + std::to_string(target_.unit) + ": " +
                       explain_exception(code, !request.is_read()) + role_hint(target_, code),
                   code};
  }
  return *response;
}

}  // namespace mbgate::ctl

// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/modbus_client.hpp"

#include <modbus/modbus.h>
#include <poll.h>

#include <array>
#include <cerrno>
#include <fmt/core.h>
#include <variant>
#include <vector>

#include "base/text.hpp"
#include "config/toml/toml_value.hpp"
#include "ctl/control/connection_shell.hpp"
#include "ctl/request/carry_out.hpp"
#include "modbus/codes.hpp"
#include "modbus/mbap.hpp"
#include "modbus/response.hpp"

namespace mbgate::ctl {
namespace {

std::string endpoint_text(const Target& target) { return host_and_port(target.host, target.port); }

void set_timeout(modbus_t& context, const Target& target) {
  const auto microseconds =
      std::chrono::duration_cast<std::chrono::microseconds>(target.timeout).count();
  modbus_set_response_timeout(&context, static_cast<std::uint32_t>(microseconds / 1'000'000),
                              static_cast<std::uint32_t>(microseconds % 1'000'000));
  modbus_set_byte_timeout(&context, 0, 0);  // the first timeout is for the whole response
}

std::string misfit_text(const modbus::Request& request, modbus::Bytes response) {
  const modbus::Bytes sent = request.pdu().bytes();
  switch (modbus::check_response(request, response)) {
    case modbus::ResponseFit::wrong_function: return "it has another function";
    case modbus::ResponseFit::wrong_length: return "its length is wrong";
    case modbus::ResponseFit::wrong_echo:
      if (request.is_read() || response.size() != sent.size() ||
          modbus::load_be16(response, 1) != modbus::load_be16(sent, 1)) {
        return "it repeats another address, value or quantity";
      }
      return fmt::format("it has the value {}, not {} (some drives limit what is written)",
                         modbus::load_be16(response, 3), modbus::load_be16(sent, 3));
    case modbus::ResponseFit::normal:
    case modbus::ResponseFit::exception: break;
  }
  return {};
}

/// What a gateway over TLS judged by, if it may be that it does not allow the request.
std::string role_hint(const Target& target, std::uint8_t code) {
  if (!target.tls || code != static_cast<std::uint8_t>(modbus::ExceptionCode::illegal_function)) {
    return {};
  }
  const std::string file = target.tls->certificate.string();
  return fmt::format("; the role in {} is {}", file, role_in_file(file));
}

}  // namespace

void Connection::Free::operator()(_modbus* context) const {
  modbus_close(context);
  modbus_free(context);
}

void Connection::close() {
  context_.reset();
  tunnel_.reset();
}

std::optional<std::string> Connection::open() {
  pollfd watched{context_ ? modbus_get_socket(context_.get()) : -1, POLLIN, 0};
  if (context_ && poll(&watched, 1, 0) == 0) {
    return std::nullopt;
  }
  close();
  const std::string prefix = fmt::format("cannot connect to {}: ", endpoint_text(target_));
  sys::UniqueFd socket;
  if (target_.tls) {
    auto tunnel = TlsTunnel::open(target_.host, target_.port, target_.timeout, *target_.tls);
    if (!tunnel) {
      return prefix + tunnel.error();
    }
    tunnel_ = *std::move(tunnel);
    socket.reset(tunnel_->take_socket());
  } else {
    auto connected = connect_tcp({target_.host, target_.port},
                                 std::chrono::steady_clock::now() + target_.timeout);
    if (!connected) {
      return prefix + connected.error();
    }
    socket = *std::move(connected);
  }
  Context context(modbus_new_tcp_pi(target_.host.c_str(), std::to_string(target_.port).c_str()));
  if (!context) {
    return prefix + modbus_strerror(errno);
  }
  set_timeout(*context, target_);
  modbus_set_socket(context.get(), socket.release());
  context_ = std::move(context);
  return std::nullopt;
}

std::string Connection::failure(int error) const {
  std::string text = endpoint_text(target_);
  switch (error) {
    case ETIMEDOUT:
      text = fmt::format("no answer from {} within {}", text, config::to_text(target_.timeout));
      break;
    case ECONNRESET:
    case EPIPE: {
      const std::string why = tunnel_ ? tunnel_->why_ended() : std::string();
      text += why.empty() ? " closed the connection without an answer" : ": " + why;
      break;
    }
    default: text += fmt::format(": {}", modbus_strerror(error)); break;
  }
  return text;
}

Result<modbus::Pdu, std::string> Connection::receive(const modbus::Request& request) {
  std::vector<std::uint8_t> outgoing{target_.unit};
  const auto pdu = request.pdu().bytes();
  outgoing.insert(outgoing.end(), pdu.begin(), pdu.end());
  if (modbus_send_raw_request(context_.get(), outgoing.data(), static_cast<int>(outgoing.size())) <
      0) {
    return failure(errno);
  }
  std::array<std::uint8_t, MODBUS_TCP_MAX_ADU_LENGTH> incoming{};
  const int size = modbus_receive_confirmation(context_.get(), incoming.data());
  if (size < 0) {
    return failure(errno);
  }
  const std::string misfit =
      fmt::format("the response of {} does not fit the request: ", endpoint_text(target_));
  const auto scan =
      modbus::scan_mbap_answer(modbus::Bytes(incoming).first(static_cast<std::size_t>(size)));
  const auto* frame = std::get_if<modbus::MbapFrame>(&scan);
  if (frame == nullptr) {
    return misfit + "it is not a Modbus TCP response";
  }
  if (frame->adu.header.transaction != 0) {  // that of libmodbus' raw requests
    return misfit + "it has another transaction identifier";
  }
  if (frame->adu.header.unit != target_.unit) {
    return fmt::format("{}it is from unit {}", misfit, frame->adu.header.unit);
  }
  if (auto why = misfit_text(request, frame->adu.pdu.bytes()); !why.empty()) {
    return misfit + why;
  }
  return frame->adu.pdu;
}

Result<modbus::Pdu, std::string> Connection::exchange(const modbus::Request& request) {
  auto response = receive(request);
  if (response) {
    return response;
  }
  close();
  return response.error() + (request.is_read() ? "" : "; the write may have been done");
}

Result<modbus::Pdu, Failure> Connection::ask(const modbus::Request& request) {
  if (auto why = open()) {
    return Failure{kExitNotDone, *std::move(why)};
  }
  const auto response = exchange(request);
  if (!response) {
    return Failure{kExitNotDone, response.error()};
  }
  if (response->is_exception()) {
    const std::uint8_t code = response->bytes()[1];
    return Failure{
        kExitNotDone,
        fmt::format("unit {}: {}{}", target_.unit, explain_exception(code, !request.is_read()),
                    role_hint(target_, code)),
        code};
  }
  return *response;
}

}  // namespace mbgate::ctl

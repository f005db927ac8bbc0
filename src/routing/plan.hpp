// SPDX-License-Identifier: Apache-2.0
// The plan of one client request: which transactions it becomes, on which buses, and how their
// responses become one. Pure data; the gateway carries it out.
//
// To change
// - word order, splitting, widening, preferred functions: device_plan, drive/values.
// - broadcasts: their forms on each bus, and devices that they do not reach: broadcast_plan;
//   addresses that stand for a broadcast (129): route_table.
// - guarded writes (communication registers, guarded values): Device::is_reconfigured_by() in
//   drive/device, may_write() in drive/profile; their refusal: device_plan, broadcast_plan.
// - a Modbus TCP server that is one device under every unit: Device::has_every_unit, set in
//   config/sections/device_section; the address in place of the unit: plan; the unit on the wire:
//   bus/tcp/tcp_discipline.
#pragma once

#include <boost/container/small_vector.hpp>
#include <cstdint>
#include <span>

#include "drive/transaction.hpp"
#include "drive/values.hpp"
#include "modbus/request.hpp"
#include "routing/route.hpp"

namespace mbgate::routing {

// How the responses of a request's transactions become the one answer of its client.

struct Reply {
  enum class Form : std::uint8_t {
    as_it_is,   ///< the response of the only transaction
    echo,       ///< the normal response to the client's own request
    registers,  ///< the data of all responses, put together
    bits
  };
  Form form = Form::as_it_is;
  std::uint16_t skip = 0;          ///< registers that were read before the first one asked for
  drive::WordExchange exchange{};  ///< over all registers that were read
};

/// How data of this table are put together.
constexpr Reply::Form data_form(modbus::Table table) {
  return modbus::holds_bits(table) ? Reply::Form::bits : Reply::Form::registers;
}

class Plan {
 public:
  /// Without its transactions: make() adds them.
  explicit Plan(const modbus::Request& request) : client_request_(request) {}
  /// Errors: 01 if the route, the client's rights or the drive deny it; 02 outside every window; 03
  /// malformed, over a limit, or cuts a value.
  static Result<Plan, modbus::ExceptionCode> make(const ResolvedRoute& resolved, std::uint8_t unit,
                                                  ClientRights rights, const modbus::Pdu& pdu);

  /// What the request would be if neither the route nor the client's rights denied it: to know what
  /// was denied.
  static Result<Plan, modbus::ExceptionCode> make_denied(const ResolvedRoute& resolved,
                                                         std::uint8_t unit, const modbus::Pdu& pdu);

  /// In their order; those of one bus stand together.
  [[nodiscard]] const auto& transactions() const { return transactions_; }
  /// The client's answer, made of the responses to its transactions: all of them, or those up to an
  /// exception.
  [[nodiscard]] modbus::Pdu answer(std::span<const drive::Transaction> done) const;
  /// The client's answer if the device gives none: the normal response to its request.
  [[nodiscard]] modbus::Pdu echo() const { return modbus::echo_response(client_request_); }
  [[nodiscard]] const modbus::Pdu& asked() const { return client_request_.pdu(); }
  [[nodiscard]] bool is_read() const { return client_request_.is_read(); }
  /// 23: nobody but the device can answer it.
  [[nodiscard]] bool is_answered_with_data() const { return client_request_.reads().has_value(); }
  [[nodiscard]] std::uint8_t function() const { return client_request_.function(); }

 private:
  static Result<Plan, modbus::ExceptionCode> make(const ResolvedRoute& resolved, std::uint8_t unit,
                                                  const modbus::Request& client_request);
  std::optional<modbus::ExceptionCode> fill(const ResolvedRoute& resolved, std::uint8_t unit);
  std::optional<modbus::ExceptionCode> add(const ResolvedRoute& resolved, std::uint8_t unit,
                                           const modbus::Request& request);
  std::optional<modbus::ExceptionCode> add_broadcast(const ResolvedRoute& resolved,
                                                     const modbus::Request& request);
  void add_question(const drive::Device& device);
  void add_questions(const ResolvedRoute& resolved, std::span<const drive::Transaction> frames,
                     BusId bus, const modbus::Request& request);
  std::optional<modbus::ExceptionCode> add_requests(const ResolvedRoute& resolved,
                                                    std::uint8_t address,
                                                    const modbus::Request& request);
  std::optional<modbus::ExceptionCode> add_device_requests(const ResolvedRoute& resolved,
                                                           std::uint8_t address,
                                                           const modbus::Request& request);

  modbus::Request client_request_;
  Reply reply_;
  boost::container::small_vector<drive::Transaction, 1> transactions_;
};

}  // namespace mbgate::routing

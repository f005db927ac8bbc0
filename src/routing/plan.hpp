// SPDX-License-Identifier: Apache-2.0
// The plan of one client request: which transactions it becomes, on which buses, and how their
// answers become one. Pure data; who carries it out is not known here.
#pragma once

#include <boost/container/small_vector.hpp>
#include <utility>

#include "modbus/request.hpp"
#include "routing/access.hpp"

namespace mbgate::routing {

struct PlannedTransaction {
  BusId bus;
  std::uint8_t address;
  modbus::Request request;
  bool silence_is_success;  ///< 08/01 and 08/04
  drive::BroadcastForm broadcast = drive::BroadcastForm::none;
};

class Plan {
 public:
  /// Errors: 01 what the route or the client's rights deny, 02 outside the window, 03 malformed.
  static Result<Plan, modbus::ExceptionCode> make(const Route& route, std::uint8_t unit,
                                                  ClientRights rights, const modbus::Pdu& pdu);

  /// One transaction; for a broadcast one on each bus.
  [[nodiscard]] const auto& transactions() const { return transactions_; }
  /// The client's answer, made of the device's.
  [[nodiscard]] modbus::Pdu answer(const modbus::Pdu& response) const;
  /// The client's answer where the device gives none: the normal response to its request.
  [[nodiscard]] modbus::Pdu echo() const { return modbus::echo_response(client_request_); }
  [[nodiscard]] bool is_read() const { return client_request_.is_read(); }
  [[nodiscard]] std::uint8_t function() const { return client_request_.function(); }

 private:
  Plan(modbus::Request request, bool rewritten)
      : client_request_(std::move(request)), rewritten_(rewritten) {}

  modbus::Request client_request_;
  bool rewritten_;
  boost::container::small_vector<PlannedTransaction, 1> transactions_;
};

}  // namespace mbgate::routing

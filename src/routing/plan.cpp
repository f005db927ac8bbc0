// SPDX-License-Identifier: Apache-2.0
#include "routing/plan.hpp"

#include <algorithm>
#include <boost/container/static_vector.hpp>

#include "modbus/frames.hpp"
#include "routing/device_plan.hpp"

namespace mbgate::routing {
namespace {

using drive::Transaction;
using modbus::ExceptionCode;
using modbus::Request;

bool may_be_silent(const Request& request) {
  if (request.function() != 0x08) {
    return false;
  }
  const std::uint16_t sub_function = modbus::load_be16(request.pdu().bytes(), 1);
  return sub_function == modbus::kRestartCommunications || sub_function == modbus::kForceListenOnly;
}

// Has the drive the function, or another one that the gateway uses for it?
bool has_function(const drive::Device& device, std::uint8_t function) {
  const auto& functions = device.profile.functions;
  return functions.test(function) ||
         (function == 0x04 && device.profile.input_as_holding && functions.test(0x03)) ||
         (function == 0x06 && device.write_function == 0x10) ||
         (function == 0x10 && device.write_function == 0x06);
}

// The most registers of an answer, and what widening adds at both ends.
constexpr std::size_t kMostData = std::size_t{2} * (125 + 2 * 3);
using Data = boost::container::static_vector<std::uint8_t, kMostData>;

// Function and byte count precede the data (Application Protocol V1.1b3, 6.1 to 6.4, 6.17).
constexpr std::size_t kHeader = 2;

modbus::Pdu with_data(std::uint8_t function, modbus::Bytes data) {
  Data pdu{function, static_cast<std::uint8_t>(data.size())};
  pdu.insert(pdu.end(), data.begin(), data.end());
  return *modbus::Pdu::from({pdu.data(), pdu.size()});
}

// Those that have a response, without the gateway's own questions.
using Answered = boost::container::small_vector<const Transaction*, 4>;

Data joined_registers(const Answered& answered) {
  Data data;
  for (const Transaction* part : answered) {
    const modbus::Bytes registers = part->response->bytes().subspan(kHeader);
    data.insert(data.end(), registers.begin(), registers.end());
  }
  return data;
}

Data joined_bits(const Answered& answered) {
  Data data;
  std::size_t total = 0;
  for (const Transaction* part : answered) {
    const modbus::Bytes bytes = part->response->bytes().subspan(kHeader);
    for (std::size_t bit = 0; bit < part->request.reads()->range.count; ++bit, ++total) {
      if (total % 8 == 0) {
        data.push_back(0);
      }
      const unsigned value = (bytes[bit / 8] >> (bit % 8)) & 1U;
      data.back() = static_cast<std::uint8_t>(data.back() | (value << (total % 8)));
    }
  }
  return data;
}

// With the value of the response: the drive may have limited what it was sent (`write_echo`).
modbus::Pdu echo_of(const modbus::Request& request, const modbus::Pdu& response) {
  constexpr std::size_t kAddressed = 3;  // function and address (6.5, 6.6)
  const modbus::Pdu echo = modbus::echo_response(request);
  if (response.function() != echo.function() || (echo.function() != 5 && echo.function() != 6)) {
    return echo;
  }
  Data pdu(echo.bytes().begin(), echo.bytes().begin() + kAddressed);
  const modbus::Bytes value = response.bytes().subspan(kAddressed);
  pdu.insert(pdu.end(), value.begin(), value.end());
  return *modbus::Pdu::from({pdu.data(), pdu.size()});
}

}  // namespace

Result<Plan, ExceptionCode> Plan::make(const ResolvedRoute& resolved, std::uint8_t unit,
                                       ClientRights rights, const modbus::Pdu& pdu) {
  if (denial_of(resolved, rights, pdu)) {
    return ExceptionCode::illegal_function;
  }
  return make_denied(resolved, unit, pdu);
}

Result<Plan, ExceptionCode> Plan::make_denied(const ResolvedRoute& resolved, std::uint8_t unit,
                                              const modbus::Pdu& pdu) {
  const auto client_request = Request::parse(pdu);
  if (!client_request) {
    return client_request.error();
  }
  return make(resolved, unit, *client_request);
}

// One object is returned, and built where it is needed: a plan is large.
Result<Plan, ExceptionCode> Plan::make(const ResolvedRoute& resolved, std::uint8_t unit,
                                       const Request& client_request) {
  Result<Plan, ExceptionCode> made{boost::system::in_place_value, client_request};
  if (const auto error = made->fill(resolved, unit)) {
    made = *error;
  }
  return made;
}

std::optional<ExceptionCode> Plan::fill(const ResolvedRoute& resolved, std::uint8_t unit) {
  if (resolved.route.windows.empty()) {  // nothing is copied
    return add(resolved, unit, client_request_);
  }
  const auto request = through_windows(resolved.route.windows, client_request_);
  return request ? add(resolved, unit, *request) : std::optional(request.error());
}

std::optional<ExceptionCode> Plan::add(const ResolvedRoute& resolved, std::uint8_t unit,
                                       const Request& request) {
  if (resolved.is_broadcast()) {
    return add_broadcast(resolved, request);
  }
  const std::uint8_t asked = resolved.route.address_of(unit);
  const auto error = add_requests(resolved, resolved.one_address.value_or(asked), request);
  for (Transaction& transaction : transactions_) {
    transaction.unit = asked;
  }
  return error;
}

std::optional<ExceptionCode> Plan::add_broadcast(const ResolvedRoute& resolved,
                                                 const Request& request) {
  const auto frames = plan_broadcast(resolved, request);
  if (!frames) {
    return frames.error();
  }
  reply_.form = Reply::Form::echo;
  for (const Transaction& frame : *frames) {
    if (transactions_.empty() || transactions_.back().bus != frame.bus) {
      add_questions(resolved, *frames, frame.bus, request);
    }
    transactions_.push_back(frame);
  }
  return std::nullopt;
}

// verify_word_order: before values are written the drive's own setting is read, in the same job, so
// that what the client sends next stays behind it.
void Plan::add_question(const drive::Device& device) {
  const std::uint16_t address = device.profile.word_order_register->address;
  Transaction question{device.address,
                       modbus::make_read({modbus::Table::holding_registers, address, 1})};
  question.bus = device.bus;
  question.must_hold = device.stated_order();
  transactions_.push_back(std::move(question));
}

void Plan::add_questions(const ResolvedRoute& resolved, std::span<const Transaction> frames,
                         BusId bus, const Request& request) {
  for (const BusDevices& known : resolved.devices_of_buses) {
    for (const drive::Device* device : known.devices) {
      const bool hears = std::ranges::any_of(frames, [&](const Transaction& it) {
        return it.bus == bus && device->is_addressed_by(it.address, it.broadcast);
      });
      if (known.bus == bus && hears && device->verify_word_order && resolved.route.word_order &&
          device->writes_value(request)) {
        add_question(*device);
      }
    }
  }
}

std::optional<ExceptionCode> Plan::add_requests(const ResolvedRoute& resolved, std::uint8_t address,
                                                const Request& request) {
  if (resolved.device != nullptr) {
    if (const auto error = add_device_requests(resolved, address, request)) {
      return error;
    }
  } else {  // nothing is known of the device: the request goes as it is
    reply_.form = request.writes() && !request.reads() ? Reply::Form::echo : Reply::Form::as_it_is;
    transactions_.emplace_back(address, request, may_be_silent(request)).bus =
        resolved.route.buses.front();
  }
  if (reply_.form == Reply::Form::as_it_is && request.function() != client_request_.function()) {
    reply_.form = data_form(request.reads()->range.table);
  }
  return std::nullopt;
}

std::optional<ExceptionCode> Plan::add_device_requests(const ResolvedRoute& resolved,
                                                       std::uint8_t address,
                                                       const Request& request) {
  const drive::Device& device = *resolved.device;
  const bool any_function = resolved.route.functions_named;
  if (!any_function && !has_function(device, request.function())) {
    return ExceptionCode::illegal_function;
  }
  const auto planned = plan_for(device, resolved.route.word_order, request);
  if (!planned) {
    return planned.error();
  }
  if (device.verify_word_order && resolved.route.word_order && !device.is_stop(request) &&
      device.writes_value(request)) {
    add_question(device);
  }
  reply_ = planned->reply;
  for (const Request& asked : planned->requests) {
    if (!any_function && !device.profile.functions.test(asked.function())) {
      return ExceptionCode::illegal_function;
    }
    transactions_.emplace_back(address, asked, may_be_silent(asked)).bus =
        resolved.route.buses.front();
  }
  return std::nullopt;
}

modbus::Pdu Plan::answer(std::span<const Transaction> done) const {
  Answered answered;
  for (const Transaction& transaction : done) {
    if (transaction.response && transaction.must_hold == nullptr) {
      answered.push_back(&transaction);
    }
  }
  const modbus::Pdu& last = *answered.back()->response;
  if (last.is_exception()) {
    return modbus::Pdu::exception(function(), static_cast<ExceptionCode>(last.bytes()[1]));
  }
  switch (reply_.form) {
    case Reply::Form::as_it_is: return last;
    case Reply::Form::echo: return echo_of(client_request_, last);
    case Reply::Form::registers: {
      Data data = joined_registers(answered);
      reply_.exchange.apply({data.data(), data.size()});
      const modbus::Bytes wanted =
          modbus::Bytes{data.data(), data.size()}.subspan(std::size_t{reply_.skip} * 2);
      return with_data(function(),
                       wanted.first(std::size_t{client_request_.reads()->range.count} * 2));
    }
    case Reply::Form::bits: {
      const Data data = joined_bits(answered);
      return with_data(function(), {data.data(), data.size()});
    }
  }
  return last;
}

}  // namespace mbgate::routing

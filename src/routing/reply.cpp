// SPDX-License-Identifier: Apache-2.0
#include "routing/reply.hpp"

#include <boost/container/static_vector.hpp>

namespace mbgate::routing {
namespace {

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

Data joined_registers(Responses responses) {
  Data data;
  for (const modbus::Pdu* response : responses) {
    const modbus::Bytes part = response->bytes().subspan(kHeader);
    data.insert(data.end(), part.begin(), part.end());
  }
  return data;
}

Data joined_bits(Responses responses, std::span<const std::uint16_t> counts) {
  Data data;
  std::size_t total = 0;
  for (std::size_t part = 0; part < responses.size(); ++part) {
    const modbus::Bytes bytes = responses[part]->bytes().subspan(kHeader);
    for (std::size_t bit = 0; bit < counts[part]; ++bit, ++total) {
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

modbus::Pdu assemble(const Reply& reply, const modbus::Request& request, Responses responses,
                     std::span<const std::uint16_t> counts) {
  const modbus::Pdu& last = *responses.back();
  if (last.is_exception()) {
    return modbus::Pdu::exception(request.function(),
                                  static_cast<modbus::ExceptionCode>(last.bytes()[1]));
  }
  switch (reply.form) {
    case Reply::Form::as_it_is: return last;
    case Reply::Form::echo: return echo_of(request, last);
    case Reply::Form::registers: {
      Data data = joined_registers(responses);
      reply.exchange.apply({data.data(), data.size()});
      const modbus::Bytes wanted =
          modbus::Bytes{data.data(), data.size()}.subspan(std::size_t{reply.skip} * 2);
      return with_data(request.function(),
                       wanted.first(std::size_t{request.reads()->range.count} * 2));
    }
    case Reply::Form::bits: {
      const Data data = joined_bits(responses, counts);
      return with_data(request.function(), {data.data(), data.size()});
    }
  }
  return last;
}

}  // namespace mbgate::routing

// SPDX-License-Identifier: Apache-2.0
// How the responses of a request's transactions become the one answer of its client.
#pragma once

#include <cstdint>
#include <span>

#include "drive/word_order.hpp"
#include "modbus/request.hpp"

namespace mbgate::routing {

/// The responses in the order of the transactions. The last one may be an exception.
using Responses = std::span<const modbus::Pdu* const>;

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

/// The answer to `request`. `counts`: how many registers or bits each transaction has read.
modbus::Pdu assemble(const Reply& reply, const modbus::Request& request, Responses responses,
                     std::span<const std::uint16_t> counts);

}  // namespace mbgate::routing

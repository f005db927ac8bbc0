// SPDX-License-Identifier: Apache-2.0
// Whether a response belongs to a request: its length by function, and the fields that it repeats.
#pragma once

#include <cstddef>

#include "modbus/request.hpp"

namespace mbgate::modbus {

/// The length of a PDU, from its first bytes.
struct PduLength {
  enum class Kind : std::uint8_t {
    known,      ///< `bytes` in all
    need_more,  ///< more bytes must come before the length is known
    opaque      ///< the function does not determine it; only silence ends the frame
  };
  Kind kind;
  std::size_t bytes = 0;
  friend bool operator==(const PduLength&, const PduLength&) = default;
};

/// The length of the response that begins with `prefix` (function code first, not empty).
/// Source: Application Protocol V1.1b3, section 6; exceptions have 2 bytes (section 7).
PduLength response_length(Bytes prefix);

/// The length that the normal response to `request` must have, if the request determines it.
PduLength expected_response_length(const Request& request);

enum class ResponseFit : std::uint8_t {
  normal,          ///< the answer
  exception,       ///< the answer: an exception of the device
  wrong_function,  ///< the answer to another function
  wrong_length,    ///< not as long as the request asks for
  wrong_echo       ///< address, value or quantity are not those of the request
};

/// Is it the answer?
constexpr bool is_fitting(ResponseFit fit) {
  return fit == ResponseFit::normal || fit == ResponseFit::exception;
}

/// Compares `response` (a PDU, not empty) with `request`: function, length, byte count of 01-04 and
/// 23, address and value or quantity of 05, 06, 15, 16, all fields of 22, the sub-function of 08
/// and 43.
ResponseFit check_response(const Request& request, Bytes response);

// The length of a request, from its first bytes. It is needed to tell the requests of another
// client on the line from the responses of devices.

/// The length of the request PDU that begins with `prefix` (function code first, not empty).
/// Source: Application Protocol V1.1b3, section 6. Opaque if the function does not determine it.
PduLength request_length(Bytes prefix);

}  // namespace mbgate::modbus

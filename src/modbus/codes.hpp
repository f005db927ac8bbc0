// SPDX-License-Identifier: Apache-2.0
// Function codes of the Application Protocol V1.1b3, section 6. Whether a function is a read
// decides about order, retries and deadlines.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "modbus/bytes.hpp"

namespace mbgate::modbus {

inline constexpr std::uint8_t kExceptionBit = 0x80;
inline constexpr std::uint8_t kReadDeviceIdentification = 0x0E;  ///< MEI type of function 43 (6.21)

/// Function codes 1-127 are valid requests (section 4.1); 0 and 128-255 are not.
constexpr bool is_request_function(std::uint8_t function) {
  return function >= 1 && function <= 127;
}

/// A read is 01-04, 07, 11, 12, 17, 20, 24 or 43/14; everything else, unknown functions included,
/// counts as a write, because it may change something. `pdu` starts with the function code and is
/// not empty.
constexpr bool is_read(Bytes pdu) {
  // A bit for each of them: this is asked some twenty times a transaction.
  constexpr std::uint32_t kReads = 1U << 0x01U | 1U << 0x02U | 1U << 0x03U | 1U << 0x04U |
                                   1U << 0x07U | 1U << 0x0BU | 1U << 0x0CU | 1U << 0x11U |
                                   1U << 0x14U | 1U << 0x18U;
  return pdu[0] < 32 ? (kReads >> pdu[0] & 1U) != 0
                     : pdu[0] == 0x2B && pdu.size() >= 2 && pdu[1] == kReadDeviceIdentification;
}

/// What may be broadcast: the writes 05, 06, 15 and 16 (Serial Line V1.02, 2.1).
constexpr bool is_broadcast_function(std::uint8_t function) {
  return function == 0x05 || function == 0x06 || function == 0x0F || function == 0x10;
}

/// Sub-functions of 08 after which a device need not answer (6.8.1).
inline constexpr std::uint16_t kRestartCommunications = 0x01;
inline constexpr std::uint16_t kChangeDelimiter = 0x03;
inline constexpr std::uint16_t kForceListenOnly = 0x04;

/// The sub-function of 08 for Modbus Plus: its answer is longer than its request.
inline constexpr std::uint16_t kModbusPlusStatistics = 0x15;

/// The standard's name, lower case; unknown and user-defined functions give an empty text.
std::string_view function_name(std::uint8_t function);

// Exception codes (Application Protocol V1.1b3, section 7), with their meaning when they come from
// the gateway itself.

enum class ExceptionCode : std::uint8_t {
  illegal_function = 0x01,                 ///< not allowed
  illegal_data_address = 0x02,             ///< outside every window
  illegal_data_value = 0x03,               ///< malformed
  server_device_failure = 0x04,            ///< devices only
  acknowledge = 0x05,                      ///< devices only
  server_device_busy = 0x06,               ///< never transmitted, try again
  memory_parity_error = 0x08,              ///< devices only
  gateway_path_unavailable = 0x0A,         ///< never transmitted, no path
  gateway_target_failed_to_respond = 0x0B  ///< transmitted, but no valid answer came
};

/// The standard's name of the code; codes of vendors have none and give an empty text.
std::string_view exception_name(std::uint8_t code);

/// "exception 0x0B (gateway target device failed to respond)"; codes of vendors without the name.
std::string exception_text(std::uint8_t code);

}  // namespace mbgate::modbus

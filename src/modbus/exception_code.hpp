// SPDX-License-Identifier: Apache-2.0
// Exception codes (Application Protocol V1.1b3, section 7), with their meaning when they come from
// the gateway itself.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace mbgate::modbus {

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

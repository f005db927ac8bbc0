// SPDX-License-Identifier: Apache-2.0
// Why the gateway itself answers with an exception: one reason for each code.
#pragma once

#include <array>
#include <cstdint>

namespace mbgate::app {

struct ExceptionReason {
  std::uint8_t code;
  const char* digits;
  const char* reason;
};

constexpr std::array kExceptionReasons = {
    ExceptionReason{0x01, "01", "not_permitted"}, ExceptionReason{0x02, "02", "no_such_address"},
    ExceptionReason{0x03, "03", "malformed"},     ExceptionReason{0x04, "04", "word_order"},
    ExceptionReason{0x06, "06", "not_sent"},      ExceptionReason{0x0A, "0A", "no_path"},
    ExceptionReason{0x0B, "0B", "no_answer"},
};

}  // namespace mbgate::app

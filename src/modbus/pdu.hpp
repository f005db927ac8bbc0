// SPDX-License-Identifier: Apache-2.0
// A protocol data unit: function code and data, 1 to 253 bytes (Application Protocol V1.1b3, 4.1).
// A Pdu always has a legal size. request.hpp and response.hpp say what its bytes mean.
#pragma once

#include <algorithm>
#include <array>
#include <optional>

#include "modbus/bytes.hpp"
#include "modbus/codes.hpp"

namespace mbgate::modbus {

inline constexpr std::size_t kMaxPduSize = 253;

class Pdu {
 public:
  /// A copy of `bytes`; nothing if there are none or more than 253.
  static std::optional<Pdu> from(Bytes bytes) {
    if (bytes.empty() || bytes.size() > kMaxPduSize) {
      return std::nullopt;
    }
    return Pdu(bytes);
  }
  /// The exception response to a request with `function`.
  static Pdu exception(std::uint8_t function, ExceptionCode code) {
    const std::array<std::uint8_t, 2> bytes{static_cast<std::uint8_t>(function | kExceptionBit),
                                            static_cast<std::uint8_t>(code)};
    return Pdu(bytes);
  }
  Pdu(const Pdu& other) : Pdu(other.bytes()) {}
  Pdu& operator=(const Pdu& other) {
    assign(other.bytes());
    return *this;
  }

  [[nodiscard]] std::uint8_t function() const { return bytes_[0]; }
  [[nodiscard]] bool is_exception() const { return (function() & kExceptionBit) != 0; }
  /// Is it the exception of a gateway that did not reach the device?
  [[nodiscard]] bool is_unreached() const {
    return *this == exception(function(), ExceptionCode::gateway_path_unavailable) ||
           *this == exception(function(), ExceptionCode::gateway_target_failed_to_respond);
  }
  [[nodiscard]] Bytes bytes() const { return {bytes_.data(), size_}; }
  [[nodiscard]] std::size_t size() const { return size_; }
  /// Overwrites the 16-bit field at `offset`, which must lie inside.
  void set_be16(std::size_t offset, std::uint16_t value) {
    store_be16({bytes_.data(), size_}, offset, value);
  }

  friend bool operator==(const Pdu& one, const Pdu& other) {
    return std::ranges::equal(one.bytes(), other.bytes());
  }

 private:
  // Bytes beyond the size have no value, and are not copied.
  explicit Pdu(Bytes bytes) { assign(bytes); }
  void assign(Bytes bytes) {
    std::copy_n(bytes.data(), bytes.size(), bytes_.data());
    size_ = static_cast<std::uint8_t>(bytes.size());
  }

  std::array<std::uint8_t, kMaxPduSize> bytes_;
  std::uint8_t size_;
};

}  // namespace mbgate::modbus

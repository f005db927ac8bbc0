// SPDX-License-Identifier: Apache-2.0
#include "modbus/pdu.hpp"

namespace mbgate::modbus {

std::optional<Pdu> Pdu::from(Bytes bytes) {
  if (bytes.empty() || bytes.size() > kMaxPduSize) {
    return std::nullopt;
  }
  return Pdu(bytes);
}

Pdu Pdu::exception(std::uint8_t function, ExceptionCode code) {
  const std::array<std::uint8_t, 2> bytes{static_cast<std::uint8_t>(function | kExceptionBit),
                                          static_cast<std::uint8_t>(code)};
  return Pdu(bytes);
}

}  // namespace mbgate::modbus

// SPDX-License-Identifier: Apache-2.0
#include "modbus/pdu.hpp"

namespace mbgate::modbus {

std::optional<Pdu> Pdu::from(Bytes bytes) {
  if (bytes.empty() || bytes.size() > kMaxPduSize) {
    return std::nullopt;
  }
  Pdu pdu;
  pdu.bytes_.assign(bytes.begin(), bytes.end());
  return pdu;
}

Pdu Pdu::exception(std::uint8_t function, ExceptionCode code) {
  Pdu pdu;
  pdu.bytes_.push_back(static_cast<std::uint8_t>(function | kExceptionBit));
  pdu.bytes_.push_back(static_cast<std::uint8_t>(code));
  return pdu;
}

}  // namespace mbgate::modbus

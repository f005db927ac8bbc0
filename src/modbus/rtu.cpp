// SPDX-License-Identifier: Apache-2.0
#include "modbus/rtu.hpp"

#include "modbus/checksum.hpp"

namespace mbgate::modbus {

RtuBytes encode_rtu(std::uint8_t address, const Pdu& pdu) {
  RtuBytes frame;
  frame.push_back(address);
  const Bytes bytes = pdu.bytes();
  frame.insert(frame.end(), bytes.begin(), bytes.end());
  const std::uint16_t crc = crc16({frame.data(), frame.size()});
  frame.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
  frame.push_back(static_cast<std::uint8_t>(crc >> 8U));
  return frame;
}

bool has_good_crc(Bytes frame) {
  // Running the CRC over a frame and its own CRC leaves nothing.
  return frame.size() >= kMinRtuSize && crc16(frame) == 0;
}

std::optional<RtuAdu> decode_rtu(Bytes frame) {
  if (frame.size() > kMaxRtuSize || !has_good_crc(frame)) {
    return std::nullopt;
  }
  return RtuAdu{frame[0], *Pdu::from(frame.subspan(1, frame.size() - kRtuOverhead))};
}

}  // namespace mbgate::modbus

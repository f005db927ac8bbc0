// SPDX-License-Identifier: Apache-2.0
#include "sim/wire/framing.hpp"

namespace mbgate::sim {

FrameBytes encode_frame(Framing framing, std::uint8_t address, const modbus::Pdu& pdu) {
  if (framing == Framing::ascii) {
    return modbus::encode_ascii(address, pdu);
  }
  const modbus::RtuBytes frame = modbus::encode_rtu(address, pdu);
  return {frame.begin(), frame.end()};
}

std::optional<modbus::RtuAdu> decode_frame(Framing framing, modbus::Bytes frame) {
  return framing == Framing::ascii ? modbus::decode_ascii(frame) : modbus::decode_rtu(frame);
}

void spoil_check(Framing framing, FrameBytes& frame) {
  if (framing == Framing::rtu) {
    frame.back() = static_cast<std::uint8_t>(~frame.back());
    return;
  }
  std::uint8_t& digit = frame[frame.size() - 3];  // before CR LF
  digit = digit == '0' ? '1' : '0';
}

}  // namespace mbgate::sim

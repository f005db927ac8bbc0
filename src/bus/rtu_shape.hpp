// SPDX-License-Identifier: Apache-2.0
// What bytes of an RTU line look like, from the first byte of a frame on: is it whole, is it good?
#pragma once

#include "modbus/request_length.hpp"
#include "modbus/rtu.hpp"

namespace mbgate::bus {

inline bool is_exception(modbus::Bytes frame) { return (frame[1] & modbus::kExceptionBit) != 0; }

/// A frame of known length that has come whole.
inline bool is_whole(modbus::Bytes bytes, const modbus::PduLength& length) {
  return length.kind == modbus::PduLength::Kind::known &&
         length.bytes + modbus::kRtuOverhead <= bytes.size();
}

inline bool is_fitting(modbus::ResponseFit fit) {
  return fit == modbus::ResponseFit::normal || fit == modbus::ResponseFit::exception;
}

inline bool is_good(modbus::Bytes bytes, const modbus::PduLength& length) {
  return is_whole(bytes, length) &&
         modbus::has_good_crc(bytes.first(length.bytes + modbus::kRtuOverhead));
}

inline bool may_become_whole(modbus::Bytes bytes, const modbus::PduLength& length) {
  return length.kind == modbus::PduLength::Kind::need_more ||
         (length.kind == modbus::PduLength::Kind::known && !is_whole(bytes, length) &&
          length.bytes + modbus::kRtuOverhead <= modbus::kMaxRtuSize);
}

inline bool is_good_request(modbus::Bytes bytes, const modbus::PduLength& length) {
  const auto pdu =
      is_good(bytes, length) ? modbus::Pdu::from(bytes.subspan(1, length.bytes)) : std::nullopt;
  return pdu && modbus::Request::parse(*pdu);
}

}  // namespace mbgate::bus

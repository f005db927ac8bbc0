// SPDX-License-Identifier: Apache-2.0
// Checks of bytes from an RTU line that may begin a frame: is the frame complete, is its CRC right?
#pragma once

#include <optional>

#include "modbus/frames.hpp"
#include "modbus/request.hpp"
#include "modbus/response.hpp"

namespace mbgate::bus {

/// The most bytes before a frame that are no part of it: line drivers turning on, and what a line
/// without bias picks up.
inline constexpr std::size_t kMostNoise = 7;

inline bool is_exception(modbus::Bytes frame) { return (frame[1] & modbus::kExceptionBit) != 0; }

/// Has a frame of known length come completely?
inline bool is_whole(modbus::Bytes bytes, const modbus::PduLength& length) {
  return length.kind == modbus::PduLength::Kind::known &&
         length.bytes + modbus::kRtuOverhead <= bytes.size();
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

/// A valid frame: a response, or a request of another client.
struct GoodFrame {
  std::size_t size;
  bool is_response;
};
/// The valid frame at the front of `bytes` (at least two), or nothing.
inline std::optional<GoodFrame> good_frame(modbus::Bytes bytes) {
  const modbus::PduLength response = modbus::response_length(bytes.subspan(1));
  if (is_good(bytes, response)) {
    return GoodFrame{response.bytes + modbus::kRtuOverhead, true};
  }
  const modbus::PduLength request = modbus::request_length(bytes.subspan(1));
  const auto pdu =
      is_good(bytes, request) ? modbus::Pdu::from(bytes.subspan(1, request.bytes)) : std::nullopt;
  if (pdu && modbus::Request::parse(*pdu)) {
    return GoodFrame{request.bytes + modbus::kRtuOverhead, false};
  }
  return std::nullopt;
}

/// Can these bytes become a frame when more come? Not if they begin with an address above 247,
/// which no device has, nor with the broadcast address, which is what noise looks like most often.
inline bool may_begin_frame(modbus::Bytes bytes) {
  const bool has_unit =
      bytes[0] != modbus::kBroadcastAddress && bytes[0] <= modbus::kMaxDeviceAddress;
  return has_unit &&
         (bytes.size() == 1 || may_become_whole(bytes, modbus::response_length(bytes.subspan(1))) ||
          may_become_whole(bytes, modbus::request_length(bytes.subspan(1))));
}

}  // namespace mbgate::bus

// SPDX-License-Identifier: Apache-2.0
// What bytes of an RTU line look like, from the first byte of a frame on: is it whole, is it good?
#pragma once

#include <optional>

#include "modbus/request_length.hpp"
#include "modbus/response.hpp"
#include "modbus/rtu.hpp"

namespace mbgate::bus {

/// Bytes before a frame that are no part of it: drivers that turn on, and what a line without bias
/// picks up.
inline constexpr std::size_t kMostNoise = 7;

inline bool is_exception(modbus::Bytes frame) { return (frame[1] & modbus::kExceptionBit) != 0; }

/// A frame of known length that has come whole.
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

inline bool is_good_request(modbus::Bytes bytes, const modbus::PduLength& length) {
  const auto pdu =
      is_good(bytes, length) ? modbus::Pdu::from(bytes.subspan(1, length.bytes)) : std::nullopt;
  return pdu && modbus::Request::parse(*pdu);
}

/// A good frame that stands here: a response, or a request of another client.
struct GoodFrame {
  std::size_t size;
  bool is_response;
};
/// Of at least two bytes.
inline std::optional<GoodFrame> good_frame(modbus::Bytes bytes) {
  const modbus::PduLength response = modbus::response_length(bytes.subspan(1));
  if (is_good(bytes, response)) {
    return GoodFrame{response.bytes + modbus::kRtuOverhead, true};
  }
  const modbus::PduLength request = modbus::request_length(bytes.subspan(1));
  if (is_good_request(bytes, request)) {
    return GoodFrame{request.bytes + modbus::kRtuOverhead, false};
  }
  return std::nullopt;
}

/// More bytes may make a frame of these. No device has an address beyond; the broadcast one is what
/// noise looks like most often.
inline bool may_begin_frame(modbus::Bytes bytes) {
  const bool has_unit =
      bytes[0] != modbus::kBroadcastAddress && bytes[0] <= modbus::kMaxDeviceAddress;
  return has_unit &&
         (bytes.size() == 1 || may_become_whole(bytes, modbus::response_length(bytes.subspan(1))) ||
          may_become_whole(bytes, modbus::request_length(bytes.subspan(1))));
}

}  // namespace mbgate::bus

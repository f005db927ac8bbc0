// SPDX-License-Identifier: Apache-2.0
#include "ctl/doctor/bus_frames.hpp"

#include <optional>

#include "modbus/request.hpp"
#include "modbus/response.hpp"
#include "modbus/rtu.hpp"

namespace mbgate::ctl {
namespace {

using modbus::Bytes;
using modbus::PduLength;

/// The size of the frame at the begin of `rest`, if its PDU has this length and its CRC is right.
std::optional<std::size_t> whole_size(Bytes rest, const PduLength& length) {
  const auto size = length.bytes + modbus::kRtuOverhead;
  const bool whole = length.kind == PduLength::Kind::known && size <= rest.size() &&
                     modbus::decode_rtu(rest.first(size));
  return whole ? std::optional(size) : std::nullopt;
}

std::optional<BusFrame> frame_at(Bytes heard, std::size_t begin) {
  const auto rest = heard.subspan(begin);
  if (rest.size() < modbus::kMinRtuSize || rest[0] > modbus::kMaxDeviceAddress) {
    return std::nullopt;
  }
  const auto request = whole_size(rest, modbus::request_length(rest.subspan(1)));
  const auto response = whole_size(rest, modbus::response_length(rest.subspan(1)));
  if (request) {
    return BusFrame{begin, *request, rest[0],
                    request == response ? FrameKind::either : FrameKind::request};
  }
  if (response) {
    return BusFrame{begin, *response, rest[0], FrameKind::response};
  }
  return std::nullopt;
}

}  // namespace

BusFrames find_frames(Bytes heard) {
  BusFrames found;
  for (std::size_t at = 0; at < heard.size();) {
    if (const auto frame = frame_at(heard, at)) {
      found.frames.push_back(*frame);
      at += frame->size;
    } else {
      ++found.stray;
      ++at;
    }
  }
  return found;
}

}  // namespace mbgate::ctl

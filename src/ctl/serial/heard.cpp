// SPDX-License-Identifier: Apache-2.0
#include "ctl/serial/heard.hpp"

#include <algorithm>

#include "modbus/request.hpp"
#include "modbus/response.hpp"

namespace mbgate::ctl {

using modbus::Bytes;
using modbus::Pdu;
using modbus::PduLength;

namespace {

/// The size of the frame at the begin of `rest`, if its PDU has this length and its CRC is right.
std::optional<std::size_t> whole_size(Bytes rest, const PduLength& length) {
  const auto size = length.bytes + modbus::kRtuOverhead;
  const bool whole = length.kind == PduLength::Kind::known && size <= rest.size() &&
                     modbus::decode_rtu(rest.first(size));
  return whole ? std::optional(size) : std::nullopt;
}

std::optional<BusFrame> frame_at(Bytes heard, std::size_t begin) {
  const auto rest = heard.subspan(begin);
  if (rest.size() < modbus::kMinRtuSize) {
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

SentRead::SentRead(std::uint8_t unit, const modbus::TableRange& read)
    : unit_(unit),
      request_(modbus::make_read(read)),
      frame_(modbus::encode_rtu(unit, request_.pdu())) {}

std::optional<std::size_t> SentRead::echo_in(Bytes received) const {
  const auto echo = std::ranges::search(received, frame_);
  return echo.empty() ? std::nullopt
                      : std::optional(static_cast<std::size_t>(echo.begin() - received.begin()));
}

Bytes SentRead::behind_echo(Bytes received) const {
  const auto echo = echo_in(received);
  return echo ? received.subspan(*echo + frame_.size()) : received;
}

std::optional<Pdu> SentRead::answer_at_begin(Bytes received) const {
  if (received.size() < modbus::kMinRtuSize || received.front() != unit_) {
    return std::nullopt;
  }
  const auto size = whole_size(received, modbus::response_length(received.subspan(1)));
  const auto adu = size ? modbus::decode_rtu(received.first(*size)) : std::nullopt;
  const bool fits = adu && modbus::is_fitting(modbus::check_response(request_, adu->pdu.bytes()));
  return fits ? std::optional(adu->pdu) : std::nullopt;
}

std::optional<Pdu> SentRead::answer_in(Bytes received) const {
  for (auto rest = behind_echo(received); !rest.empty(); rest = rest.subspan(1)) {
    if (auto answer = answer_at_begin(rest)) {
      return answer;
    }
  }
  return std::nullopt;
}

Heard SentRead::understand(Bytes received) const {
  const auto rest = behind_echo(received);
  Heard heard;
  heard.bytes = rest.size();
  if (rest.empty()) {
    return heard;
  }
  if (auto answer = answer_in(received)) {
    heard.kind = HeardKind::answer;
    heard.response = *std::move(answer);
  } else if (const auto other = modbus::decode_rtu(rest)) {
    heard.kind = HeardKind::other_frame;
    heard.unit = other->address;
  } else {
    const bool begun = rest.size() >= modbus::kMinRtuSize && rest[0] == unit_ &&
                       (rest[1] & ~modbus::kExceptionBit) == request_.function();
    heard.kind = begun ? HeardKind::bad_crc : HeardKind::noise;
  }
  return heard;
}

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

// SPDX-License-Identifier: Apache-2.0
#include "sim/wire/request_framer.hpp"

#include <utility>
#include <vector>

#include "modbus/response.hpp"

namespace mbgate::sim {
namespace {

// More than two of the largest frames without one that holds is noise.
constexpr std::size_t kMostBytes = 2 * modbus::kMaxRtuSize;

constexpr std::uint8_t kDiagnostics = 0x08;

}  // namespace

std::optional<std::size_t> request_frame_length(modbus::Bytes prefix) {
  if (prefix.size() < 2) {
    return std::nullopt;
  }
  std::vector<std::uint8_t> pdu(prefix.begin() + 1, prefix.end());
  pdu[0] = static_cast<std::uint8_t>(pdu[0] & ~modbus::kExceptionBit);  // of the AiC's broadcasts
  if (pdu[0] == kDiagnostics) {
    return 8;  // with two bytes of data, which nearly all its sub-functions have
  }
  const auto length = modbus::request_length(pdu);
  return length.kind == modbus::PduLength::Kind::known ? std::optional(1 + length.bytes + 2)
                                                       : std::nullopt;
}

void RequestFramer::feed(modbus::Bytes bytes, Instant now) {
  if (bytes_.empty()) {
    begin_ = now;
  }
  last_ = now;
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

std::optional<ReceivedFrame> RequestFramer::poll(Instant now) {
  if (bytes_.empty()) {
    return std::nullopt;
  }
  const auto length = request_frame_length(bytes_);
  if (length && bytes_.size() >= *length &&
      modbus::has_good_crc(modbus::Bytes(bytes_).first(*length))) {
    const auto end = bytes_.begin() + static_cast<std::ptrdiff_t>(*length);
    ReceivedFrame frame{{bytes_.begin(), end}, begin_};
    bytes_.erase(bytes_.begin(), end);
    begin_ = last_;
    return frame;
  }
  if (now >= last_ + silence_ || bytes_.size() > kMostBytes) {
    return ReceivedFrame{std::exchange(bytes_, {}), begin_};
  }
  return std::nullopt;
}

std::optional<Instant> RequestFramer::deadline() const {
  return bytes_.empty() ? std::nullopt : std::optional(last_ + silence_);
}

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

std::optional<AsciiFrame> AsciiFramer::feed(std::uint8_t character, bus::Instant begin,
                                            bus::Instant end) {
  std::optional<AsciiFrame> ended;
  const bool given_up = !frame_.bytes.empty() && (character == modbus::kAsciiStart ||
                                                  begin - frame_.end > kAsciiCharacterTimeout);
  if (given_up) {
    ended = std::exchange(frame_, {});
  }
  if (character == modbus::kAsciiStart) {
    frame_.begin = begin;
  } else if (frame_.bytes.empty()) {
    return ended;
  }
  frame_.bytes.push_back(character);
  frame_.end = end;
  if (character == modbus::kAsciiEnd || frame_.bytes.size() > modbus::kMaxAsciiSize) {
    ended = std::exchange(frame_, {});
  }
  return ended;
}

}  // namespace mbgate::sim

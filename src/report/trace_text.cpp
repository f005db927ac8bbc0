// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <fmt/core.h>

#include "modbus/describe.hpp"
#include "modbus/response.hpp"
#include "report/text.hpp"

namespace mbgate::report {
namespace {

using namespace gateway;
using modbus::Bytes;
using modbus::Direction;

ByteString all_heard(const WireTrace& wire) {
  ByteString all;
  for (const HeardBytes& part : wire.heard) {
    all.insert(all.end(), part.bytes.begin(), part.bytes.end());
  }
  return all;
}

/// Of bytes that nobody had asked for: whose meaning fits.
Direction direction_of(const modbus::RtuAdu& adu) {
  const Bytes pdu = adu.pdu.bytes();
  const auto length = modbus::response_length(pdu);
  const bool may_be_response = length.kind != modbus::PduLength::Kind::known ||
                               length.bytes == pdu.size() || adu.pdu.is_exception();
  return may_be_response || !modbus::Request::parse(adu.pdu) ? Direction::response
                                                             : Direction::request;
}

/// What is wrong with bytes that are no good RTU frame. A CRC is only called wrong where the bytes
/// are as many as a frame of their function has.
std::string bad_rtu(Bytes bytes) {
  const std::string size = std::to_string(bytes.size()) + (bytes.size() == 1 ? " byte" : " bytes");
  if (bytes.size() < modbus::kMinRtuSize) {
    return size + ", too few for a frame";
  }
  constexpr std::size_t kCrc = 2;
  const Bytes body = bytes.first(bytes.size() - kCrc);
  const auto length = modbus::response_length(body.subspan(1));
  if (length.kind != modbus::PduLength::Kind::known) {
    return size + ", no frame";
  }
  const std::size_t whole = length.bytes + modbus::kRtuOverhead;
  if (bytes.size() < whole) {
    return fmt::format("{} of {}: the frame is incomplete", size, whole);
  }
  if (bytes.size() > whole) {
    return size + ", not exactly one frame";
  }
  const std::uint16_t crc = modbus::crc16(body);
  const std::uint8_t right[] = {static_cast<std::uint8_t>(crc),
                                static_cast<std::uint8_t>(crc >> 8)};
  return fmt::format("CRC {}, {} would be right", modbus::hex(bytes.last(kCrc)),
                     modbus::hex(right));
}

std::string rtu_text(Bytes bytes, Direction direction) {
  const auto adu = modbus::decode_rtu(bytes);
  return adu ? modbus::describe_adu(*adu, direction) : bad_rtu(bytes);
}

std::string ascii_text(Bytes bytes, Direction direction) {
  if (const auto adu = modbus::decode_ascii(bytes)) {
    return modbus::describe_adu(*adu, direction);
  }
  return modbus::ascii_content(bytes) ? "its LRC is wrong" : "no complete ASCII frame";
}

/// Is the frame of the response that was taken among these bytes?
bool has_response(const WireTrace& wire, Bytes bytes) {
  const auto pdu = modbus::Pdu::from(*wire.response);
  const auto has = [&](const auto& frame) { return !std::ranges::search(bytes, frame).empty(); };
  switch (wire.framing) {
    case bus::Framing::rtu: return pdu && has(modbus::encode_rtu(wire.address, *pdu));
    case bus::Framing::ascii: return pdu && has(modbus::encode_ascii(wire.address, *pdu));
    case bus::Framing::tcp: return false;
  }
  return false;
}

std::string frame_text(const WireTrace& wire, Bytes bytes, Direction direction) {
  switch (wire.framing) {
    case bus::Framing::rtu: return rtu_text(bytes, direction);
    case bus::Framing::ascii: return ascii_text(bytes, direction);
    case bus::Framing::tcp: return modbus::describe_mbap(bytes, direction);
  }
  return {};
}

}  // namespace

const char* to_text(WireTrace::Outcome outcome) {
  constexpr std::array kTexts{"answered", "sent", "no response", "damaged", "cut", "unasked"};
  return kTexts.at(static_cast<std::size_t>(outcome));
}

const char* to_text(bus::Ending ending, bool was_sent) {
  switch (ending) {
    case bus::Ending::answered: return "answered";
    case bus::Ending::transmitted: return "transmitted";
    case bus::Ending::no_answer: return "no valid answer came";
    case bus::Ending::expired: return "its deadline had passed";
    case bus::Ending::mismatched: return "the drive's word order is not the configured one";
    case bus::Ending::closed: return "the line is not open";
    case bus::Ending::offline: return "the device is offline";
    case bus::Ending::cancelled:
      return was_sent ? "cancelled before it was done" : "cancelled before it was sent";
  }
  return "";
}

std::string sent_text(const WireTrace& wire) {
  return frame_text(wire, wire.frame, Direction::request);
}

std::string heard_text(const WireTrace& wire) {
  const ByteString all = all_heard(wire);
  const auto frame = modbus::decode_rtu(all);
  if (wire.outcome == WireTrace::Outcome::unasked && wire.framing == bus::Framing::rtu && frame) {
    return modbus::describe_adu(*frame, direction_of(*frame));
  }
  Bytes rest = all;
  std::string text;
  const bool has_same = !wire.frame.empty() && rest.size() >= wire.frame.size() &&
                        std::ranges::equal(rest.first(wire.frame.size()), wire.frame);
  if (has_same && (!wire.response || has_response(wire, rest.subspan(wire.frame.size())))) {
    text = "the same bytes as sent, then ";
    rest = rest.subspan(wire.frame.size());
  }
  if (wire.response) {
    return text + modbus::describe_response(*wire.response);
  }
  return text + (rest.empty() ? "nothing" : frame_text(wire, rest, Direction::response));
}

}  // namespace mbgate::report

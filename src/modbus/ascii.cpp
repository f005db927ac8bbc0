// SPDX-License-Identifier: Apache-2.0
#include "modbus/ascii.hpp"

#include <string_view>

#include "modbus/checksum.hpp"

namespace mbgate::modbus {
namespace {

constexpr std::string_view kDigits = "0123456789ABCDEF";
constexpr std::uint8_t kCarriageReturn = '\r';

void append_byte(AsciiBytes& frame, std::uint8_t byte) {
  frame.push_back(static_cast<std::uint8_t>(kDigits[byte >> 4U]));
  frame.push_back(static_cast<std::uint8_t>(kDigits[byte & 0xFU]));
}

std::optional<unsigned> value_of(std::uint8_t character) {
  if (character >= '0' && character <= '9') {
    return character - '0';
  }
  if (character >= 'A' && character <= 'F') {
    return character - 'A' + 10;
  }
  if (character >= 'a' && character <= 'f') {
    return character - 'a' + 10;
  }
  return std::nullopt;
}

bool is_framed(Bytes frame) {
  return frame.size() >= kMinAsciiSize && frame.size() <= kMaxAsciiSize && frame.size() % 2 == 1 &&
         frame.front() == kAsciiStart && frame[frame.size() - 2] == kCarriageReturn &&
         frame.back() == kAsciiEnd;
}

}  // namespace

AsciiBytes encode_ascii(std::uint8_t address, const Pdu& pdu) {
  AsciiContent content{address};
  const Bytes bytes = pdu.bytes();
  content.insert(content.end(), bytes.begin(), bytes.end());
  content.push_back(lrc({content.data(), content.size()}));
  AsciiBytes frame{kAsciiStart};
  for (const std::uint8_t byte : content) {
    append_byte(frame, byte);
  }
  frame.push_back(kCarriageReturn);
  frame.push_back(kAsciiEnd);
  return frame;
}

std::optional<AsciiContent> ascii_content(Bytes frame) {
  if (!is_framed(frame)) {
    return std::nullopt;
  }
  AsciiContent content;
  for (std::size_t at = 1; at < frame.size() - 2; at += 2) {
    const auto high = value_of(frame[at]);
    const auto low = value_of(frame[at + 1]);
    if (!high || !low) {
      return std::nullopt;
    }
    content.push_back(static_cast<std::uint8_t>((*high << 4U) | *low));
  }
  return content;
}

bool has_good_lrc(Bytes content) { return content.size() >= kMinAsciiContent && lrc(content) == 0; }

std::optional<RtuAdu> decode_ascii(Bytes frame) {
  const auto content = ascii_content(frame);
  if (!content || !has_good_lrc({content->data(), content->size()})) {
    return std::nullopt;
  }
  const Bytes bytes(content->data(), content->size());
  return RtuAdu{bytes[0], *Pdu::from(bytes.subspan(1, bytes.size() - 2))};
}

}  // namespace mbgate::modbus

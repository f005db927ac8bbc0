// SPDX-License-Identifier: Apache-2.0
#include "modbus/frames.hpp"

#include <array>
#include <numeric>
#include <string_view>

#include "base/text.hpp"

namespace mbgate::modbus {
namespace {

using CrcTable = std::array<std::uint16_t, 256>;

// What a byte makes of the CRC when so many other bytes have followed it.
constexpr std::array<CrcTable, 4> make_tables() {
  std::array<CrcTable, 4> tables{};
  for (unsigned byte = 0; byte < tables[0].size(); ++byte) {
    unsigned value = byte;
    for (CrcTable& table : tables) {
      for (int bit = 0; bit < 8; ++bit) {
        value = (value & 1U) != 0 ? (value >> 1U) ^ 0xA001U : value >> 1U;
      }
      table[byte] = static_cast<std::uint16_t>(value);
    }
  }
  return tables;
}

constexpr auto kTables = make_tables();

constexpr std::string_view kDigits = "0123456789ABCDEF";

bool is_framed(Bytes frame) {
  return frame.size() >= kMinAsciiSize && frame.size() <= kMaxAsciiSize && frame.size() % 2 == 1 &&
         frame.front() == kAsciiStart && frame[frame.size() - 2] == kCarriageReturn &&
         frame.back() == kAsciiEnd;
}

}  // namespace

std::uint16_t crc16(Bytes bytes) {
  unsigned crc = 0xFFFF;
  for (; bytes.size() >= 4; bytes = bytes.subspan(4)) {
    const auto four = bytes.first<4>();
    crc = kTables[3][(crc ^ four[0]) & 0xFFU] ^ kTables[2][(crc >> 8U) ^ four[1]] ^
          kTables[1][four[2]] ^ kTables[0][four[3]];
  }
  for (const std::uint8_t byte : bytes) {
    crc = (crc >> 8U) ^ kTables[0][(crc ^ byte) & 0xFFU];
  }
  return static_cast<std::uint16_t>(crc);
}

std::uint8_t lrc(Bytes bytes) {
  const unsigned sum = std::accumulate(bytes.begin(), bytes.end(), 0U);
  return static_cast<std::uint8_t>(0U - sum);
}

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

AsciiBytes encode_ascii(std::uint8_t address, const Pdu& pdu) {
  AsciiContent content{address};
  const Bytes bytes = pdu.bytes();
  content.insert(content.end(), bytes.begin(), bytes.end());
  content.push_back(lrc({content.data(), content.size()}));
  AsciiBytes frame{kAsciiStart};
  for (const std::uint8_t byte : content) {
    frame.push_back(static_cast<std::uint8_t>(kDigits[byte >> 4U]));
    frame.push_back(static_cast<std::uint8_t>(kDigits[byte & 0xFU]));
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
    const std::array pair{static_cast<char>(frame[at]), static_cast<char>(frame[at + 1])};
    const auto byte = integer_in<std::uint8_t>({pair.data(), pair.size()}, 16);
    if (!byte) {
      return std::nullopt;
    }
    content.push_back(*byte);
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

// SPDX-License-Identifier: Apache-2.0
#include "world/frames.hpp"

#include <algorithm>
#include <array>

namespace mbgate::world {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;

std::uint64_t rounded_up(std::uint64_t dividend, std::uint64_t divisor) {
  return dividend / divisor + (dividend % divisor == 0 ? 0 : 1);
}

// 6.1 to 6.4, 6.11, 6.12 and 6.17.
constexpr unsigned kMostBits = 2000;
constexpr unsigned kMostRegisters = 125;
constexpr unsigned kMostCoils = 1968;
constexpr unsigned kMostWritten = 123;
constexpr unsigned kMostWrittenBeside = 121;

bool is_within(unsigned count, unsigned most) { return count >= 1 && count <= most; }

Range holding(Bytes pdu, std::size_t at, unsigned count) {
  return {Table::holding_registers, word_at(pdu, at), count};
}

std::optional<Fields> read_fields(Bytes pdu, Table table, unsigned most) {
  if (pdu.size() != 5 || !is_within(word_at(pdu, 3), most)) {
    return std::nullopt;
  }
  return Fields{.reads = Range{table, word_at(pdu, 1), word_at(pdu, 3)}};
}

// Address, quantity, byte count, registers.
std::optional<Fields> write_fields(Bytes pdu, std::size_t at, unsigned most) {
  const std::size_t data = at + 5;
  if (pdu.size() < data) {
    return std::nullopt;
  }
  const unsigned count = word_at(pdu, at + 2);
  if (!is_within(count, most) || pdu[at + 4] != 2 * count || pdu.size() != data + 2 * count) {
    return std::nullopt;
  }
  Fields fields{.writes = holding(pdu, at, count)};
  for (std::size_t word = 0; word < count; ++word) {
    fields.words.push_back(word_at(pdu, data + 2 * word));
  }
  return fields;
}

std::optional<Fields> coil_fields(Bytes pdu) {
  if (pdu.size() != 5 || (pdu[3] != 0 && pdu[3] != 0xFF) || pdu[4] != 0) {
    return std::nullopt;
  }
  const bool on = pdu[3] == 0xFF;
  return Fields{.writes = Range{Table::coils, word_at(pdu, 1), 1}, .words = {std::uint16_t{on}}};
}

std::optional<Fields> coils_fields(Bytes pdu) {
  if (pdu.size() < 6) {
    return std::nullopt;
  }
  const unsigned count = word_at(pdu, 3);
  const unsigned bytes = (count + 7) / 8;
  if (!is_within(count, kMostCoils) || pdu[5] != bytes || pdu.size() != 6 + bytes) {
    return std::nullopt;
  }
  Fields fields{.writes = Range{Table::coils, word_at(pdu, 1), count}};
  for (std::size_t coil = 0; coil < count; ++coil) {
    const unsigned byte = pdu[6 + coil / 8];
    fields.words.push_back(static_cast<std::uint16_t>(byte >> coil % 8 & 1U));
  }
  return fields;
}

// What a low byte becomes by eight shifts, each of which takes the polynomial if a bit falls out.
constexpr auto kShifted = [] {
  std::array<std::uint16_t, 256> shifted{};
  for (unsigned byte = 0; byte < shifted.size(); ++byte) {
    unsigned value = byte;
    for (int bit = 0; bit < 8; ++bit) {
      const bool falls_out = (value & 1U) != 0;
      value = value >> 1U ^ (falls_out ? 0xA001U : 0U);
    }
    shifted[byte] = static_cast<std::uint16_t>(value);
  }
  return shifted;
}();

// The two's complement of the sum (Serial Line V1.02, 6.2.1).
std::uint8_t lrc(Bytes bytes) {
  unsigned sum = 0;
  for (const std::uint8_t byte : bytes) {
    sum += byte;
  }
  return low(0x100U - (sum & 0xFFU));
}

std::optional<unsigned> digit(std::uint8_t character) {
  if (character >= '0' && character <= '9') {
    return character - '0';
  }
  if (character >= 'A' && character <= 'F') {
    return character - 'A' + 10;
  }
  return std::nullopt;
}

}  // namespace

std::uint16_t word_at(Bytes bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] * 256U + bytes[at + 1]);
}

std::optional<Fields> fields_of(Bytes pdu) {
  switch (pdu[0]) {
    case 0x01: return read_fields(pdu, Table::coils, kMostBits);
    case 0x02: return read_fields(pdu, Table::discrete_inputs, kMostBits);
    case 0x03: return read_fields(pdu, Table::holding_registers, kMostRegisters);
    case 0x04: return read_fields(pdu, Table::input_registers, kMostRegisters);
    case 0x05: return coil_fields(pdu);
    case 0x06:
      return pdu.size() != 5
                 ? std::nullopt
                 : std::optional(Fields{.writes = holding(pdu, 1, 1), .words = {word_at(pdu, 3)}});
    case 0x0F: return coils_fields(pdu);
    case 0x10: return write_fields(pdu, 1, kMostWritten);
    case 0x16:
      return pdu.size() != 7 ? std::nullopt
                             : std::optional(Fields{.writes = holding(pdu, 1, 1),
                                                    .words = {word_at(pdu, 3), word_at(pdu, 5)}});
    case 0x17: {
      auto fields = pdu.size() < 10 ? std::nullopt : write_fields(pdu, 5, kMostWrittenBeside);
      if (!fields || !is_within(word_at(pdu, 3), kMostRegisters)) {
        return std::nullopt;
      }
      fields->reads = holding(pdu, 1, word_at(pdu, 3));
      return fields;
    }
    default: return Fields{};
  }
}

void append_word(Octets& bytes, unsigned word) {
  bytes.push_back(high(word));
  bytes.push_back(low(word));
}

Octets request(unsigned function, unsigned first, unsigned second) {
  return {low(function), high(first), low(first), high(second), low(second)};
}

std::string hex(Bytes bytes) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += {kDigits[byte >> 4U], kDigits[byte & 15U]};
  }
  return text;
}

bool is_opaque(Bytes pdu) {
  constexpr unsigned kNoForm = 0x7F;  // of a broadcast
  const unsigned function = pdu[0] & kNoForm;
  if (function == 0x2B) {
    return pdu.size() < 2 || pdu[1] != kIdentification;
  }
  return !(function >= 0x01 && function <= 0x08) && function != 0x0B && function != 0x0C &&
         !(function >= 0x0F && function <= 0x11) && !(function >= 0x14 && function <= 0x18);
}

std::size_t data_size_of(const Range& read) {
  const bool is_bits = read.table == Table::coils || read.table == Table::discrete_inputs;
  return is_bits ? (read.count + 7) / 8 : 2 * std::size_t{read.count};
}

std::uint16_t crc(Bytes bytes) {
  unsigned value = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    value = value >> 8U ^ kShifted[(value ^ byte) & 0xFFU];
  }
  return static_cast<std::uint16_t>(value);
}

// The CRC of a frame with its CRC is 0, and of no other.
bool ends_in_its_crc(Bytes frame) { return frame.size() >= 4 && crc(frame) == 0; }

Octets rtu_frame(std::uint8_t address, Bytes pdu) {
  Octets frame{address};
  frame.insert(frame.end(), pdu.begin(), pdu.end());
  const unsigned check = crc(frame);
  frame.push_back(low(check));
  frame.push_back(low(check >> 8U));
  return frame;
}

Octets ascii_frame(std::uint8_t address, Bytes pdu) {
  Octets content{address};
  content.insert(content.end(), pdu.begin(), pdu.end());
  content.push_back(lrc(content));
  const std::string frame = ':' + hex(content) + "\r\n";
  return {frame.begin(), frame.end()};
}

Octets tcp_adu(std::uint16_t identifier, std::uint8_t unit, Bytes pdu) {
  const auto length = static_cast<unsigned>(pdu.size() + 1);
  Octets adu{low(identifier >> 8U), low(identifier), 0, 0, low(length >> 8U), low(length), unit};
  adu.insert(adu.end(), pdu.begin(), pdu.end());
  return adu;
}

std::optional<Adu> read_rtu(Bytes frame) {
  if (frame.size() > kRtuFrame || !ends_in_its_crc(frame)) {
    return std::nullopt;
  }
  return Adu{frame[0], {frame.begin() + 1, frame.end() - 2}};
}

std::optional<Adu> read_ascii(Bytes frame) {
  constexpr std::size_t kShortest = 9;
  if (frame.size() < kShortest || frame.size() > kAsciiFrame || frame.size() % 2 == 0 ||
      frame[0] != ':' || frame[frame.size() - 2] != '\r' || frame.back() != '\n') {
    return std::nullopt;
  }
  Octets content;
  for (std::size_t at = 1; at + 2 < frame.size(); at += 2) {
    const auto upper = digit(frame[at]);
    const auto lower = digit(frame[at + 1]);
    if (!upper || !lower) {
      return std::nullopt;
    }
    content.push_back(low(*upper * 16 + *lower));
  }
  const std::uint8_t check = content.back();
  content.pop_back();
  if (check != lrc(content)) {
    return std::nullopt;
  }
  return Adu{content[0], {content.begin() + 1, content.end()}};
}

WireTimes::WireTimes(const bus::LineSettings& line)
    : bits_(1U + line.format.data_bits + (line.format.parity == modbus::Parity::none ? 0U : 1U) +
            line.format.stop_bits),
      baud_(static_cast<std::uint32_t>(line.baud)) {}

Duration WireTimes::of(std::size_t characters) const {
  return Duration(rounded_up(characters * bits_ * kSecond, baud_));
}

Duration WireTimes::silence() const {
  return baud_ > 19200 ? 1750us : Duration(rounded_up(7 * bits_ * kSecond, 2 * baud_));
}

Duration slack_of(const bus::BusSettings& bus) {
  return bus.frame_slack.value_or(bus.line.remote ? 200ms : 20ms);
}

Duration silence_of(const bus::BusSettings& bus) {
  return bus.frame_gap ? *bus.frame_gap : WireTimes(bus.line).silence();
}

Duration quarantine_of(const drive::DeviceTiming& timing) {
  return timing.quarantine ? *timing.quarantine : timing.response_timeout;
}

Duration probe_timeout_of(const drive::DeviceTiming& timing) {
  return std::min<Duration>(timing.probe_timeout.value_or(100ms), timing.response_timeout / 2);
}

}  // namespace mbgate::world

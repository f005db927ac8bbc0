// SPDX-License-Identifier: Apache-2.0
#include "soak/specification.hpp"

#include <algorithm>
#include <array>

namespace mbgate::soak::spec {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kSecond = 1'000'000'000;

std::uint64_t rounded_up(std::uint64_t dividend, std::uint64_t divisor) {
  return dividend / divisor + (dividend % divisor == 0 ? 0 : 1);
}

std::uint8_t low(unsigned value) { return static_cast<std::uint8_t>(value & 0xFFU); }

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

std::uint16_t crc(Bytes bytes) {
  unsigned value = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    value = value >> 8U ^ kShifted[(value ^ byte) & 0xFFU];
  }
  return static_cast<std::uint16_t>(value);
}

bool ends_in_its_crc(Bytes frame) {
  if (frame.size() < 4) {
    return false;
  }
  const unsigned expected = crc(frame.first(frame.size() - 2));
  return frame[frame.size() - 2] == low(expected) && frame.back() == low(expected >> 8U);
}

Octets rtu_frame(std::uint8_t address, Bytes pdu) {
  Octets frame{address};
  frame.insert(frame.end(), pdu.begin(), pdu.end());
  const unsigned check = crc(frame);
  frame.push_back(low(check));
  frame.push_back(low(check >> 8U));
  return frame;
}

Octets ascii_frame(std::uint8_t address, Bytes pdu) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  Octets content{address};
  content.insert(content.end(), pdu.begin(), pdu.end());
  content.push_back(lrc(content));
  Octets frame{':'};
  for (const std::uint8_t byte : content) {
    frame.push_back(static_cast<std::uint8_t>(kDigits[byte / 16]));
    frame.push_back(static_cast<std::uint8_t>(kDigits[byte % 16]));
  }
  frame.insert(frame.end(), {'\r', '\n'});
  return frame;
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

Duration silence_of(const bus::BusSettings& bus) {
  return bus.frame_gap ? *bus.frame_gap : WireTimes(bus.line).silence();
}

Duration slack_of(const bus::BusSettings& bus) {
  if (bus.frame_slack) {
    return *bus.frame_slack;
  }
  return bus.line.remote ? 200ms : 20ms;
}

// At least `stop_wait` and 1.1 times the longest frame.
Duration stop_deadline_of(const bus::BusSettings& bus) {
  if (bus.stop_deadline) {
    return *bus.stop_deadline;
  }
  const bool ascii = bus.line.framing == bus::Framing::ascii;
  const Duration longest = WireTimes(bus.line).of(ascii ? kAsciiFrame : kRtuFrame);
  return std::max<Duration>(2s, bus.stop_wait + longest + longest / 10);
}

Duration quarantine_of(const drive::DeviceTiming& timing) {
  return timing.quarantine ? *timing.quarantine : timing.response_timeout;
}

Duration probe_timeout_of(const drive::DeviceTiming& timing) {
  return timing.probe_timeout ? *timing.probe_timeout
                              : std::min<Duration>(timing.response_timeout, 100ms);
}

}  // namespace mbgate::soak::spec

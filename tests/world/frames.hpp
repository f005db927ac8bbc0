// SPDX-License-Identifier: Apache-2.0
// Frames and requests, written once more from the Modbus specifications. The world is built on this
// and not on the product's own code, so that the two cannot share a mistake.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bus/settings.hpp"
#include "drive/device.hpp"

namespace mbgate::world {

using namespace std::chrono_literals;
using Bytes = std::span<const std::uint8_t>;
using Octets = std::vector<std::uint8_t>;
using bus::Duration;
using bus::Instant;
using modbus::Table;

/// An address and a PDU.
struct Adu {
  std::uint8_t address;
  Octets pdu;
};

struct Range {
  modbus::Table table;
  unsigned first;
  unsigned count;
};
/// What a request is about (Application Protocol V1.1b3, 6.1 to 6.17).
struct Fields {
  std::optional<Range> reads{};
  std::optional<Range> writes{};
  std::vector<std::uint16_t> words{};  ///< that it writes; of a coil 0 or 1, of 22 both masks
};

/// Of what a read brings, behind its function and byte count (6.1 to 6.4).
std::size_t data_size_of(const Range& read);

/// Of the longest RTU frame, and of the longest ASCII frame (Serial Line V1.02, 2.5.1 and 2.5.2).
inline constexpr std::size_t kRtuFrame = 256;
inline constexpr std::size_t kAsciiFrame = 513;
inline constexpr std::uint8_t kIdentification = 0x0E;  ///< of 43, the MEI type that reads

/// The word at a place, high byte first (Application Protocol V1.1b3, 4.2).
std::uint16_t word_at(Bytes bytes, std::size_t at);
constexpr std::uint8_t high(unsigned value) {
  return static_cast<std::uint8_t>(value >> 8U & 0xFFU);
}
constexpr std::uint8_t low(unsigned value) { return static_cast<std::uint8_t>(value & 0xFFU); }
void append_word(Octets& bytes, unsigned word);
/// A function and two words: what most requests are.
Octets request(unsigned function, unsigned first, unsigned second);
std::string hex(Bytes bytes);

/// Nothing: its length does not fit, or it asks for too much. Of functions that name no table both
/// are empty.
std::optional<Fields> fields_of(Bytes pdu);
/// Of a request: nothing says how long its answer is, only silence ends it.
bool is_opaque(Bytes pdu);

/// Serial Line V1.02, 6.2.2.
std::uint16_t crc(Bytes bytes);
/// Does the frame end in the CRC of what stands before?
bool ends_in_its_crc(Bytes frame);

Octets rtu_frame(std::uint8_t address, Bytes pdu);
Octets ascii_frame(std::uint8_t address, Bytes pdu);
/// Messaging on TCP/IP V1.0b, 3.1.3.
Octets tcp_adu(std::uint16_t identifier, std::uint8_t unit, Bytes pdu);

/// Nothing if it is no such frame.
std::optional<Adu> read_rtu(Bytes frame);
std::optional<Adu> read_ascii(Bytes frame);

/// How long characters take on a line.
class WireTimes {
 public:
  explicit WireTimes(const bus::LineSettings& line);
  /// One after the other.
  [[nodiscard]] Duration of(std::size_t characters) const;
  /// t3.5: 3.5 characters, above 19200 baud 1.75 ms (Serial Line V1.02, 2.5.1.1).
  [[nodiscard]] Duration silence() const;

 private:
  std::uint64_t bits_;  // of a character
  std::uint64_t baud_;
};

/// The longest pause within an answer: `frame_slack`, 20 ms, or 200 ms behind `tcp://`.
Duration slack_of(const bus::BusSettings& bus);
/// Between frames: `frame_gap`, or t3.5.
Duration silence_of(const bus::BusSettings& bus);
/// `quarantine`, or one more response timeout.
Duration quarantine_of(const drive::DeviceTiming& timing);
/// `probe_timeout`, or 100 ms; half of the response timeout at most.
Duration probe_timeout_of(const drive::DeviceTiming& timing);

}  // namespace mbgate::world

// SPDX-License-Identifier: Apache-2.0
// Frames of a serial line, RTU and ASCII, and their checksums.
#pragma once

#include <boost/container/static_vector.hpp>
#include <cstdint>
#include <optional>

#include "modbus/bytes.hpp"
#include "modbus/pdu.hpp"

namespace mbgate::modbus {

// CRC-16 of RTU frames (Serial Line V1.02, 6.2.2): polynomial 0xA001 reflected, initial value
// 0xFFFF.

/// The CRC of `bytes`. On the wire its low byte goes first.
std::uint16_t crc16(Bytes bytes);

// LRC of ASCII frames (Serial Line V1.02, 6.2.1): the two's complement of the sum of all bytes,
// carries dropped.

/// The LRC of `bytes`: the bytes that the characters stand for, not the characters. It is 0 for
/// bytes that end with their own LRC.
std::uint8_t lrc(Bytes bytes);

// An RTU frame: address, PDU, CRC; 4 to 256 bytes (Serial Line V1.02, 2.5.1).

inline constexpr std::size_t kMinRtuSize = 4;
inline constexpr std::size_t kMaxRtuSize = 256;
inline constexpr std::size_t kRtuOverhead = 3;  ///< address and CRC

/// Addresses of the serial line (Serial Line V1.02, 2.2).
inline constexpr std::uint8_t kBroadcastAddress = 0;
inline constexpr std::uint8_t kMaxDeviceAddress = 247;

using RtuBytes = boost::container::static_vector<std::uint8_t, kMaxRtuSize>;

struct RtuAdu {
  std::uint8_t address;
  Pdu pdu;
};

/// The frame with its CRC, low byte first.
RtuBytes encode_rtu(std::uint8_t address, const Pdu& pdu);

/// Does the frame, CRC included, have the right CRC? False below 4 bytes.
bool has_good_crc(Bytes frame);

/// The frame's parts; nothing if its size is illegal or its CRC is wrong.
std::optional<RtuAdu> decode_rtu(Bytes frame);

// An ASCII frame: ':', address, PDU and LRC as two hexadecimal characters a byte, CR LF; 9 to 513
// characters (Serial Line V1.02, 2.5.2). Upper-case digits are sent, both cases are understood.

inline constexpr std::size_t kAsciiFraming = 3;  ///< ':', CR and LF
/// Address, function and LRC; with the longest PDU.
inline constexpr std::size_t kMinAsciiContent = 3;
inline constexpr std::size_t kMaxAsciiContent = kMaxPduSize + 2;
inline constexpr std::size_t kMinAsciiSize = kAsciiFraming + 2 * kMinAsciiContent;  // 9
inline constexpr std::size_t kMaxAsciiSize = kAsciiFraming + 2 * kMaxAsciiContent;  // 513

inline constexpr std::uint8_t kAsciiStart = ':';
inline constexpr std::uint8_t kCarriageReturn = '\r';  ///< before the end
inline constexpr std::uint8_t kAsciiEnd = '\n';

using AsciiBytes = boost::container::static_vector<std::uint8_t, kMaxAsciiSize>;
/// What the characters between ':' and CR LF stand for: address, PDU, LRC.
using AsciiContent = boost::container::static_vector<std::uint8_t, kMaxAsciiContent>;

/// The characters of the whole frame.
AsciiBytes encode_ascii(std::uint8_t address, const Pdu& pdu);

/// The content of a frame, whether its LRC is right or not. Nothing unless the frame is exactly
/// ':', pairs of hexadecimal characters for 3 to 255 bytes, and CR LF.
std::optional<AsciiContent> ascii_content(Bytes frame);

/// Does the content, LRC included, have the right LRC? False below 3 bytes.
bool has_good_lrc(Bytes content);

/// The frame's parts; nothing if the frame is damaged in any way, its LRC included.
std::optional<RtuAdu> decode_ascii(Bytes frame);

}  // namespace mbgate::modbus

// SPDX-License-Identifier: Apache-2.0
// An ASCII frame: ':', address, PDU and LRC as two hexadecimal characters a byte, CR LF; 9 to 513
// characters (Serial Line V1.02, 2.5.2). Upper-case digits are sent, both cases are understood.
#pragma once

#include <boost/container/static_vector.hpp>
#include <cstdint>
#include <optional>

#include "modbus/pdu.hpp"
#include "modbus/rtu.hpp"

namespace mbgate::modbus {

inline constexpr std::size_t kAsciiFraming = 3;  ///< ':', CR and LF
/// Address, function and LRC; with the longest PDU.
inline constexpr std::size_t kMinAsciiContent = 3;
inline constexpr std::size_t kMaxAsciiContent = kMaxPduSize + 2;
inline constexpr std::size_t kMinAsciiSize = kAsciiFraming + 2 * kMinAsciiContent;  // 9
inline constexpr std::size_t kMaxAsciiSize = kAsciiFraming + 2 * kMaxAsciiContent;  // 513

inline constexpr std::uint8_t kAsciiStart = ':';
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

// SPDX-License-Identifier: Apache-2.0
// An RTU frame: address, PDU, CRC; 4 to 256 bytes (Serial Line V1.02, 2.5.1).
#pragma once

#include <boost/container/static_vector.hpp>
#include <cstdint>
#include <optional>

#include "modbus/pdu.hpp"

namespace mbgate::modbus {

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

}  // namespace mbgate::modbus

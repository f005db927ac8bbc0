// SPDX-License-Identifier: Apache-2.0
// The MBAP header and the stream of ADUs on a TCP connection (Messaging on TCP/IP V1.0b, 3.1.3).
#pragma once

#include <boost/container/static_vector.hpp>
#include <cstdint>
#include <string_view>
#include <variant>

#include "modbus/pdu.hpp"

namespace mbgate::modbus {

inline constexpr std::size_t kMbapHeaderSize = 7;
inline constexpr std::size_t kMaxMbapAduSize = kMbapHeaderSize + kMaxPduSize;  // 260

struct MbapHeader {
  std::uint16_t transaction = 0;  ///< echoed exactly
  std::uint8_t unit = 0;          ///< echoed exactly
  friend bool operator==(const MbapHeader&, const MbapHeader&) = default;
};

/// A whole request or response.
struct MbapAdu {
  MbapHeader header;
  Pdu pdu;
};

using MbapBytes = boost::container::static_vector<std::uint8_t, kMaxMbapAduSize>;

/// The bytes of an ADU as they go to the socket.
MbapBytes encode(const MbapAdu& adu);

/// What is at the front of a stream. `size`: how many bytes to remove.
struct MbapIncomplete {};
struct MbapFrame {
  MbapAdu adu;
  std::size_t size;
};
/// An ADU with a protocol identifier other than 0 and a possible length: exactly this ADU is to be
/// skipped.
struct MbapForeign {
  std::uint16_t protocol;
  std::size_t size;
};
/// A length below 2 or above 254: it cannot be known any more where the next ADU begins.
struct MbapLost {
  std::uint16_t length;
};
using MbapScan = std::variant<MbapIncomplete, MbapFrame, MbapForeign, MbapLost>;

/// Looks at the front of `stream`, which TCP may have split and coalesced in any way. Keeps no
/// state.
MbapScan scan_mbap(Bytes stream);
/// The same in a stream of responses. An exception has two bytes (Application Protocol V1.1b3, 7),
/// whatever its length says: there are servers that send these two and count more of them.
MbapScan scan_mbap_answer(Bytes stream);

/// Do the bytes begin with an RTU frame (address, a known function, good CRC)? A frequent mistake
/// of users, worth a log line of its own.
bool looks_like_rtu(Bytes stream);

/// What a stream is that is neither MBAP nor RTU: "Modbus ASCII" (a colon; Serial Line V1.02,
/// 2.5.2.1), "TLS" (a handshake record; RFC 8446, 5.1), "HTTP" (a method; RFC 9112, 3), or "".
std::string_view other_protocol(Bytes stream);

}  // namespace mbgate::modbus

// SPDX-License-Identifier: Apache-2.0
#include "modbus/request_length.hpp"

namespace mbgate::modbus {
namespace {

using Kind = PduLength::Kind;

PduLength fixed(std::size_t bytes) { return {Kind::known, bytes}; }

// The byte count at `offset` counts all that follows it.
PduLength counted_at(Bytes prefix, std::size_t offset) {
  return prefix.size() <= offset ? PduLength{Kind::need_more} : fixed(offset + 1 + prefix[offset]);
}

}  // namespace

PduLength request_length(Bytes prefix) {
  switch (prefix[0]) {
    case 0x01:
    case 0x02:
    case 0x03:
    case 0x04:
    case 0x05:
    case 0x06: return fixed(5);
    case 0x07:
    case 0x0B:
    case 0x0C:
    case 0x11: return fixed(1);
    case 0x0F:
    case 0x10: return counted_at(prefix, 5);
    case 0x14:
    case 0x15: return counted_at(prefix, 1);
    case 0x16: return fixed(7);
    case 0x17: return counted_at(prefix, 9);
    case 0x18: return fixed(3);
    default: return {Kind::opaque};
  }
}

}  // namespace mbgate::modbus

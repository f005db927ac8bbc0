// SPDX-License-Identifier: Apache-2.0
// What stands beside each other on a serial line makes no frame that nobody has sent.
#include <algorithm>

#include "soak/serial_wire.hpp"

namespace mbgate::soak {

// The answer that a length ends is over; behind one that only silence ends more may come. One that
// pauses behind its address may have a damaged echo within that ends in the address too, as that of
// 01 03 00 28 00 04 C4 01 does: no frame begins there, and it must not look so.
void SerialWire::overhear(Message& message, std::size_t until) {
  for (std::size_t at = message.heard; at < until && !ascii_; ++at) {
    std::uint8_t& byte = message.bytes[at];
    const std::size_t lead = message.content.lead;
    if (at == 0 || (at >= lead && (at - lead) % message.frame == 0)) {
      message.frame_from = overheard_.count();
    }
    if (!message.is_of_frame(at)) {
      byte = overheard_.add_stray(byte, asked_);
      continue;
    }
    const bool ends = at >= lead && (at + 1 - lead) % message.frame == 0;
    const std::size_t size = ends ? message.frame : at + 1 == lead ? at + 1 : 0;
    const bool in_one = overheard_.count() + 1 - message.frame_from == size;
    const std::uint8_t heard = overheard_.add(byte, asked_, in_one ? size : 0);
    if (heard != byte) {
      byte = heard;
      message.good_to = at;
      message.content.copies =
          std::min(message.content.copies, message.ended(at) - message.ended(message.heard));
      around_.report.fault("chance_crc");
    } else if (ends && !opaque_) {
      overheard_.forget();
    }
  }
}

void SerialWire::overhear(Frame& bytes, bool are_stray) {
  for (std::size_t at = 0; at < bytes.size() && !ascii_; ++at) {
    if (are_stray) {
      bytes[at] = overheard_.add_stray(bytes[at], asked_);
    } else {
      overheard_.add(bytes[at]);
    }
  }
}

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
// What went over a line, as packets for Wireshark: good frames for the dissector that knows them,
// all else as bytes with a comment that says what they are.
#pragma once

#include <vector>

#include "ctl/trace/pcapng.hpp"

namespace mbgate::ctl {

/// In the order of the line. The bytes are those of LinkType::upper_pdu. What is no good frame is
/// never given to a dissector of Modbus, which would call it malformed.
std::vector<CapturedPacket> bus_packets(const TracedFrame& frame);

}  // namespace mbgate::ctl

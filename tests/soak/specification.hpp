// SPDX-License-Identifier: Apache-2.0
// Frames, requests and times, written once more from the Modbus specifications (world/frames):
// nothing that the gateway computes them with is what it is judged by, or what its devices
// understand.
#pragma once

#include "drive/device.hpp"
#include "world/frames.hpp"

namespace mbgate::soak::spec {

using bus::Duration;
using world::Adu;
using world::ascii_frame;
using world::Bytes;
using world::crc;
using world::data_size_of;
using world::ends_in_its_crc;
using world::Fields;
using world::fields_of;
using world::is_opaque;
using world::kAsciiFrame;
using world::kIdentification;
using world::kLongestPdu;
using world::kRtuFrame;
using world::Octets;
using world::Range;
using world::read_ascii;
using world::read_rtu;
using world::rtu_frame;
using world::slack_of;
using world::tcp_adu;
using world::WireTimes;
using world::word_at;

/// Drives hear the one as they hear the other.
bool is_same_line(const bus::LineSettings& a, const bus::LineSettings& b);

/// What is asked for between frames.
Duration silence_of(const bus::BusSettings& bus);
/// Until a stop goes out though the line was never silent.
Duration stop_deadline_of(const bus::BusSettings& bus);
Duration quarantine_of(const drive::DeviceTiming& timing);
Duration probe_timeout_of(const drive::DeviceTiming& timing);

}  // namespace mbgate::soak::spec

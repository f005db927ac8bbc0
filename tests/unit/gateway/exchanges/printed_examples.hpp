// SPDX-License-Identifier: Apache-2.0
// The printed examples of the drive manuals in the form in which they go through the machine, and
// the steps of such a passage.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "manuals/vectors.hpp"
#include "modbus/frames.hpp"
#include "support/machine_rig.hpp"

namespace mbgate::test {

/// One transaction on both sides, as hexadecimal text.
struct Example {
  std::string where;
  std::string tcp_request;
  std::string rtu_request;
  std::string rtu_response;
  std::string tcp_response;
};

inline constexpr std::uint32_t kRouted = 0;
inline constexpr std::uint32_t kTransparent = 1;

/// One bus behind a routed listener with an identity route and behind a transparent one.
inline Settings routed_and_transparent() {
  Settings settings = one_bus();
  auto& transparent = settings.listeners.emplace_back();
  transparent.name = "service";
  transparent.bus = BusId{0};
  for (auto& listener : settings.listeners) {
    listener.pipeline = 64;
  }
  return settings;
}

/// The RTU frame of an address and a PDU.
inline std::string rtu_of(modbus::Bytes address_and_pdu) {
  const auto frame =
      modbus::encode_rtu(address_and_pdu[0], modbus::Pdu::from(address_and_pdu.subspan(1)).value());
  return hex({frame.data(), frame.size()});
}

/// The TCP ADU of an RTU frame with a right CRC: MBAP with transaction identifier 0, and the
/// PDU.
inline std::string tcp_of(modbus::Bytes rtu) {
  manuals::ByteList tcp{0, 0, 0, 0, 0, static_cast<std::uint8_t>(rtu.size() - 2)};
  tcp.insert(tcp.end(), rtu.begin(), rtu.end() - 2);
  return hex(tcp);
}

/// The example of a request, for which `rtu_response` comes back. Where the manual prints no
/// response, the device answers with MOONS' vendor exception 0x13, which must pass unchanged too.
inline Example example_of(const std::string& where, modbus::Bytes rtu_request,
                          const manuals::ByteList* rtu_response) {
  Example example{where, tcp_of(rtu_request), hex(rtu_request), {}, {}};
  if (rtu_response != nullptr) {
    example.rtu_response = hex(*rtu_response);
  } else {
    const auto function = static_cast<std::uint8_t>(rtu_request[1] | modbus::kExceptionBit);
    example.rtu_response = rtu_of(manuals::ByteList{rtu_request[0], function, 0x13});
  }
  example.tcp_response = tcp_of(unhex(example.rtu_response));
  return example;
}

/// Every pair of the MOONS' manual, its TCP ADUs as they are printed.
inline std::vector<Example> printed_pairs() {
  std::vector<Example> examples;
  for (const auto& [request, response] : manuals::load_transactions()) {
    examples.push_back(
        example_of(request.where(), request.rtu, response ? &response->rtu : nullptr));
    examples.back().tcp_request = hex(request.tcp);
    if (response) {
      examples.back().tcp_response = hex(response->tcp);
    }
  }
  return examples;
}

/// Every RTU frame of every manual, with the TCP ADU that it must come from.
inline std::vector<Example> printed_frames() {
  const auto frames = manuals::load_rtu();
  std::vector<Example> examples;
  for (const manuals::Frame& frame : frames) {
    if (frame.direction == manuals::Direction::request) {
      const auto answer = std::ranges::find_if(frames, [&](const manuals::Frame& other) {
        return other.manual == frame.manual && other.answers == frame.line;
      });
      examples.push_back(example_of(frame.where(), frame.bytes,
                                    answer != frames.end() ? &answer->bytes : nullptr));
    }
  }
  return examples;
}

/// The one of these examples that is printed at `where`.
inline Example example_at(const std::vector<Example>& examples, const std::string& where) {
  const auto found = std::ranges::find(examples, where, &Example::where);
  if (found == examples.end()) {
    throw std::runtime_error("no example at " + where);
  }
  return *found;
}

/// The oldest line of `lines` once there is one; empty if none comes within `limit`.
inline std::string next_line(MachineRig& rig, const Lines& lines, Duration limit) {
  for (Duration waited{0}; lines.empty() && waited < limit; waited += 5ms) {
    rig.advance(5ms);
  }
  return lines.empty() ? std::string() : lines.front();
}

/// The next frame on the line, or nothing.
inline std::string next_frame(MachineRig& rig, Duration limit = 5s) {
  Lines& frames = rig.transmitted[0];
  const std::string frame = next_line(rig, frames, limit);
  frames.erase(frames.begin(), frames.begin() + (frames.empty() ? 0 : 1));
  return frame;
}

/// The next ADU for the client, or nothing.
inline std::string next_adu(MachineRig& rig, std::uint64_t client, Duration limit = 5s) {
  Lines& adus = rig.sent[client];
  const std::string adu = next_line(rig, adus, limit);
  adus.erase(adus.begin(), adus.begin() + (adus.empty() ? 0 : 1));
  return adu;
}

inline void expect_exchange(MachineRig& rig, std::uint64_t client, const Example& example) {
  rig.receive(client, example.tcp_request);
  ASSERT_EQ(next_frame(rig), example.rtu_request) << example.where;
  rig.advance(20ms);
  rig.line(example.rtu_response);
  EXPECT_EQ(next_adu(rig, client), example.tcp_response) << example.where;
}

/// Another client is served as if nothing had happened.
inline void expect_undisturbed(MachineRig& rig, std::uint64_t other) {
  expect_exchange(rig, other, printed_pairs().front());
  EXPECT_FALSE(rig.closed.contains(other));
}

}  // namespace mbgate::test

// SPDX-License-Identifier: Apache-2.0
// Drives with their shipped profiles behind routes of a machine on a bench, and simulated drives
// that answer frame by frame where a manual prints no response.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "config/profiles/profile_library.hpp"
#include "modbus/frames.hpp"
#include "unit/gateway/exchanges/printed_examples.hpp"

namespace mbgate::test {

using drive::WordOrder;

/// nullopt: a route that exchanges nothing.
using Seen = std::optional<WordOrder>;

inline const config::ProfileFile& shipped_profile(std::string_view name) {
  static config::ProfileLibrary library({MBGATE_SOURCE_DIR "/conf/profiles"});
  const config::ProfileFile* file = library.find(name);
  if (file == nullptr) {
    throw std::runtime_error("no profile is named " + std::string(name) + '\n' +
                             render(library.diagnostics()));
  }
  return *file;
}

/// What a user has who names a profile and nothing else, but for the word order where the maker
/// lets it be set.
inline drive::Device device_with(const std::string& profile, std::optional<WordOrder> set,
                                 std::uint8_t address = 1) {
  drive::Device device;
  device.name = profile;
  device.profile = shipped_profile(profile).profile;
  device.address = address;
  device.word_order = device.profile.word_order_settable ? set : device.profile.word_order;
  device.timing.response_timeout = 100ms;
  device.timing.response_wait = device.profile.response_wait;
  return device;
}

/// One bus; each device behind the unit of its address, on routes that show this word order.
inline Settings routes_to(std::vector<drive::Device> devices, Seen seen) {
  Settings settings = one_bus();
  settings.routes.clear();
  settings.devices = std::move(devices);
  for (std::size_t index = 0; index < settings.devices.size(); ++index) {
    auto& route = settings.routes.emplace_back();
    route.first_unit = route.last_unit = route.first_address = settings.devices[index].address;
    route.buses = {BusId{0}};
    route.device = index;
    route.word_order = seen;
  }
  return settings;
}

inline Settings route_to(const drive::Device& device, Seen seen) {
  return routes_to({device}, seen);
}

/// The frame that the simulated drive answers with.
template <typename Drive>
std::string simulated_response(Drive& drive, const std::string& rtu_request) {
  const auto request = modbus::decode_rtu(unhex(rtu_request)).value();
  const modbus::Pdu pdu = drive.answer(request.pdu).response.value();
  manuals::ByteList bytes{unhex(rtu_request).front()};
  bytes.insert(bytes.end(), pdu.bytes().begin(), pdu.bytes().end());
  return rtu_of(bytes);
}

/// Examples whose response no manual prints are answered 0x13 by printed_examples.hpp; no printed
/// response of a MOONS' drive or of a stepper is an exception.
inline bool prints_response(const Example& example) {
  return (unhex(example.rtu_response).at(1) & modbus::kExceptionBit) == 0;
}

template <typename Drive>
void answer_by(Drive& drive, Example& example) {
  const std::string response = simulated_response(drive, example.rtu_request);
  if (!prints_response(example)) {
    example.rtu_response = response;
    example.tcp_response = tcp_of(unhex(response));
  }
}

inline modbus::Request request_of(const std::string& rtu) {
  return *modbus::Request::parse(modbus::decode_rtu(unhex(rtu)).value().pdu);
}

/// What the request reads or writes.
inline modbus::TableRange range_of(const modbus::Request& request) {
  return request.reads() ? request.reads()->range : request.writes().value().range;
}

/// The gateway answers by itself, and nothing is transmitted.
inline void expect_refusal(MachineRig& rig, std::uint64_t client, const Example& example,
                           std::uint8_t code) {
  const manuals::ByteList rtu = unhex(example.rtu_request);
  const auto function = static_cast<std::uint8_t>(rtu[1] | modbus::kExceptionBit);
  rig.receive(client, example.tcp_request);
  EXPECT_EQ(next_adu(rig, client), tcp_of(unhex(rtu_of(manuals::ByteList{rtu[0], function, code}))))
      << example.where;
  EXPECT_EQ(next_frame(rig, 1s), "") << example.where;
}

}  // namespace mbgate::test

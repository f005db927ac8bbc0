// SPDX-License-Identifier: Apache-2.0
// A plant with drives of all four makers as an engineer would configure it: profiles, word orders,
// one unit each, big-endian for everybody.
#pragma once

#include <gmock/gmock.h>

#include "config/profiles/profile_file.hpp"
#include "simulation/world.hpp"
#include "support/hex.hpp"

namespace mbgate::test {

using drive::WordOrder;

class Families : public testing::Test {
 protected:
  /// Units 1 to 5: an M3 with PR=133, a stepper, an AiC and an M3 with PR=5 on one RTU line, an
  /// FDA6000 on an ASCII line. Unit 0 reaches everybody.
  static constexpr unsigned kM3 = 1;
  static constexpr unsigned kStepper = 2;
  static constexpr unsigned kAic = 3;
  static constexpr unsigned kM3Big = 4;
  static constexpr unsigned kFda = 5;

  Families() {
    auto& listener = settings_.listeners.emplace_back();
    listener.name = "plant";
    listener.pipeline = 64;
    add_bus("line-a", 115200, {8, modbus::Parity::none, 1}, bus::Framing::rtu);
    add_bus("line-b", 19200, {7, modbus::Parity::even, 1}, bus::Framing::ascii);
    add("moons-m3", 0,
        {.address = 1,
         .model = sim::ModelKind::moons,
         .word_order = WordOrder::little,
         .series = sim::MoonsSeries::m3});
    add("rs485-stepper", 0, {.address = 2, .model = sim::ModelKind::stepper});
    add("autonics-aic", 0, {.address = 17, .model = sim::ModelKind::aic, .response_wait = 20ms});
    add("moons-m3", 0,
        {.address = 4,
         .model = sim::ModelKind::moons,
         .word_order = WordOrder::big,
         .series = sim::MoonsSeries::m3});
    add("higen-fda6000", 1, {.address = 5, .model = sim::ModelKind::fda6000});
    auto& all = settings_.routes.emplace_back();
    all.buses = {BusId{0}};
  }

  void build() {
    world_.emplace(settings_, devices_, [this](ClientId, modbus::Bytes adu) {
      answers_.push_back(hex(adu.subspan(7)));
    });
    client_ = world_->connect(0, 1);
  }
  /// The answer to one request, both without their headers.
  std::string ask(unsigned unit, std::string_view pdu) {
    send(unit, pdu);
    world_->run(world_->now() + 10s, [this] { return !answers_.empty(); });
    return answers_.empty() ? "no answer" : std::exchange(answers_, {}).front();
  }
  void send(unsigned unit, std::string_view pdu) {
    const auto bytes = unhex(pdu);
    const auto size = static_cast<std::uint8_t>(bytes.size() + 1);
    std::vector<std::uint8_t> adu{0, 1, 0, 0, 0, size, static_cast<std::uint8_t>(unit)};
    adu.insert(adu.end(), bytes.begin(), bytes.end());
    world_->send(client_, adu);
  }
  [[nodiscard]] sim::Device& device(unsigned unit) {
    const auto& target = settings_.devices[unit - 1];
    return *world_->wire(static_cast<std::size_t>(target.bus)).device(target.address);
  }
  [[nodiscard]] std::uint64_t frames() { return world_->wire(0).counters().frames; }

  gateway::Settings settings_;
  std::vector<std::vector<sim::DeviceSettings>> devices_;
  std::optional<World> world_;
  ClientId client_{};
  std::vector<std::string> answers_;

 private:
  void add_bus(const char* name, std::uint32_t baud, const modbus::CharacterFormat& format,
               bus::Framing framing) {
    auto& bus = settings_.buses.emplace_back();
    bus.name = name;
    bus.line.baud = modbus::Baud{baud};
    bus.line.format = format;
    bus.line.framing = framing;
    bus.line.echo = false;
    bus.listen_first = 0ms;
    devices_.emplace_back();
  }
  void add(const std::string& profile, std::uint32_t bus, const sim::DeviceSettings& simulated) {
    auto loaded = config::load_profile(config::read_text_file(
        std::string(MBGATE_SOURCE_DIR "/conf/profiles/") + profile + ".toml"));
    drive::Device device;
    device.name = profile;
    device.bus = BusId{bus};
    device.address = simulated.address;
    device.profile = loaded.file.value().profile;
    device.word_order = device.profile.word_order_settable ? std::optional(simulated.word_order)
                                                           : device.profile.word_order;
    device.timing.response_timeout = 50ms;
    device.timing.response_wait = simulated.response_wait.value_or(0ms);
    settings_.devices.push_back(device);
    devices_[bus].push_back(simulated);
    auto& route = settings_.routes.emplace_back();
    route.first_unit = route.last_unit = static_cast<std::uint8_t>(settings_.devices.size());
    route.buses = {device.bus};
    route.first_address = device.address;
    route.device = settings_.devices.size() - 1;
    route.word_order = WordOrder::big;
  }
};

}  // namespace mbgate::test

// SPDX-License-Identifier: Apache-2.0
// Simulated plants whose every register tells where it came from, and clients that ask for them.
#pragma once

#include <gtest/gtest.h>

#include <random>

#include "simulation/oracle.hpp"

namespace mbgate::test {

inline constexpr std::uint16_t kFirst =
    0x003C;  // MOONS' user registers 40061 to 40104: 44 registers, any value
inline constexpr std::uint16_t kRegisters = 44;

inline BusPlan bus_plan(std::initializer_list<std::uint8_t> units,
                        modbus::Baud baud = modbus::Baud{115200}) {
  BusPlan plan;
  plan.bus.line.baud = baud;
  plan.bus.line.format = {8, modbus::Parity::none, 1};
  plan.bus.listen_first = 0ms;
  plan.bus.timing.response_timeout = 100ms;
  for (const std::uint8_t unit : units) {
    sim::DeviceSettings device;
    device.name = "drive-" + std::to_string(unit);
    device.address = unit;
    plan.devices.push_back(device);
  }
  return plan;
}

inline sim::Faults fault(bool sim::Faults::*kind) {
  sim::Faults faults;
  faults.*kind = true;
  return faults;
}

inline sim::Faults exceptions_every(unsigned requests) {
  sim::Faults faults;
  faults.exception_every = requests;
  return faults;
}

/// Registers of a drive.
struct Registers {
  std::uint8_t unit;
  std::uint16_t first;
  std::uint16_t count;
};

class Traffic : public testing::Test {
 protected:
  void build(const std::vector<BusPlan>& buses) {
    world_.emplace(buses, [this](ClientId client, modbus::Bytes answer) {
      oracle_.take(client, answer);
      if (on_answer_) {
        on_answer_(client);
      }
    });
    units_.clear();
    for (const BusPlan& plan : buses) {
      units_.emplace_back();
      for (const auto& device : plan.devices) {
        units_.back().push_back(device.address);
      }
    }
  }
  /// Writes every register's own value through the gateway.
  void fill_registers() {
    for (std::size_t bus = 0; bus < units_.size(); ++bus) {
      const ClientId client = world_->connect(bus, 200);
      for (const std::uint8_t unit : units_[bus]) {
        const auto pdu = write_pdu(unit, kFirst, kRegisters);
        oracle_.expect(client, unit, adu(unit, unit, {pdu.begin(), pdu.begin() + 5}));
        world_->send(client, adu(unit, unit, pdu));
        finish(world_->now() + 10s);
      }
      world_->disconnect(client);
    }
  }
  void read(ClientId client, std::uint16_t transaction, const Registers& asked,
            bool may_fail = false) {
    const auto answer = data_pdu(asked.unit, asked.first, asked.count);
    oracle_.expect(client, transaction, adu(transaction, asked.unit, answer), may_fail);
    world_->send(client, adu(transaction, asked.unit, read_pdu(asked.first, asked.count)));
  }
  void random_read(ClientId client, std::size_t bus, std::uint16_t transaction,
                   bool may_fail = false) {
    const auto offset = static_cast<std::uint16_t>(random_() % kRegisters);
    const auto count =
        static_cast<std::uint16_t>(1 + random_() % std::min(10, kRegisters - offset));
    const std::uint8_t unit = units_[bus][random_() % units_[bus].size()];
    read(client, transaction, {unit, static_cast<std::uint16_t>(kFirst + offset), count}, may_fail);
  }
  void finish(Instant limit) {
    world_->run(limit, [this] { return oracle_.open() == 0; });
    ASSERT_EQ(oracle_.open(), 0U) << "requests without an answer";
  }

  std::mt19937 random_{20261120};
  Oracle oracle_;
  std::optional<World> world_;
  std::vector<std::vector<std::uint8_t>> units_;
  std::function<void(ClientId)> on_answer_;
};

}  // namespace mbgate::test

// SPDX-License-Identifier: Apache-2.0
// Gateway and drives in virtual time: much traffic, faults, clients that come and go.
#include <gtest/gtest.h>

#include "simulation/oracle.hpp"

namespace mbgate::test {
namespace {

constexpr std::uint16_t kFirst =
    0x003C;  // MOONS' user registers 40061 to 40104: 44 registers, any value
constexpr std::uint16_t kRegisters = 44;

BusPlan bus_plan(std::initializer_list<std::uint8_t> units,
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

sim::Faults fault(bool sim::Faults::*kind) {
  sim::Faults faults;
  faults.*kind = true;
  return faults;
}

sim::Faults exceptions_every(unsigned requests) {
  sim::Faults faults;
  faults.exception_every = requests;
  return faults;
}

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
    for (std::size_t bus = 0; bus < buses.size(); ++bus) {
      units_.emplace_back();
      for (const auto& device : buses[bus].devices) {
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
  void read(ClientId client, std::uint16_t transaction, std::uint8_t unit, std::uint16_t address,
            std::uint16_t count, bool may_fail = false) {
    oracle_.expect(client, transaction, adu(transaction, unit, data_pdu(unit, address, count)),
                   may_fail);
    world_->send(client, adu(transaction, unit, read_pdu(address, count)));
  }
  void random_read(ClientId client, std::size_t bus, std::uint16_t transaction,
                   bool may_fail = false) {
    const auto offset = static_cast<std::uint16_t>(random_() % kRegisters);
    const auto count =
        static_cast<std::uint16_t>(1 + random_() % std::min(10, kRegisters - offset));
    const std::uint8_t unit = units_[bus][random_() % units_[bus].size()];
    read(client, transaction, unit, static_cast<std::uint16_t>(kFirst + offset), count, may_fail);
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

TEST_F(Traffic, SixtyFourClientsOnTwoPacedBusesGetAThousandAnswersEach) {
  build({bus_plan({1, 2, 3}), bus_plan({4, 5}, modbus::Baud{460800})});
  fill_registers();
  struct Client {
    std::size_t bus;
    std::uint16_t sent = 0;
  };
  std::map<ClientId, Client> clients;
  constexpr std::uint16_t kRequests = 1000;
  constexpr int kDepth = 2;
  const auto ask = [&](ClientId id) {
    Client& client = clients.at(id);
    if (client.sent < kRequests) {
      random_read(id, client.bus, client.sent++);
    }
  };
  for (unsigned number = 0; number < 64; ++number) {
    const std::size_t bus = number % 2;
    clients.emplace(world_->connect(bus, number), Client{bus});
  }
  for (const auto& [id, client] : clients) {
    for (int depth = 0; depth < kDepth; ++depth) {
      ask(id);
    }
  }
  const std::uint64_t before = oracle_.answered();
  on_answer_ = ask;
  finish(world_->now() + 2h);
  EXPECT_EQ(oracle_.answered() - before, 64U * kRequests);
  EXPECT_EQ(world_->silence_violations(), 0U);
  EXPECT_EQ(world_->collisions(), 0U);
}

TEST_F(Traffic, RequestsSplitAtEveryByteGiveTheSameAnswers) {
  build({bus_plan({1}), bus_plan({1})});
  fill_registers();
  for (unsigned host = 0; host < 64; ++host) {
    const ClientId client = world_->connect(host % 2, host);
    std::vector<std::uint8_t> twenty;
    for (std::uint16_t transaction = 0; transaction < 20; ++transaction) {
      const auto address = static_cast<std::uint16_t>(kFirst + transaction);
      oracle_.expect(client, transaction, adu(transaction, 1, data_pdu(1, address, 2)));
      const auto request = adu(transaction, 1, read_pdu(address, 2));
      twenty.insert(twenty.end(), request.begin(), request.end());
    }
    const auto cut = static_cast<std::ptrdiff_t>(host * 240 / 64);
    world_->send(client, std::span(twenty).first(static_cast<std::size_t>(cut)));
    world_->send(client, std::span(twenty).subspan(static_cast<std::size_t>(cut)));
  }
  finish(world_->now() + 1min);
}

TEST_F(Traffic, ASilentDeviceCostsItsClientsTheStatedTimeAndOtherBusesNothing) {
  build({bus_plan({1, 2}), bus_plan({3})});
  fill_registers();
  world_->wire(0).device(2)->set_faults(fault(&sim::Faults::silent));
  const ClientId victim = world_->connect(0, 1);
  const ClientId other = world_->connect(1, 2);
  // Two tries of 100 ms, 8 characters of 10 bits and t3.5 at 115200 baud.
  const Duration limit = 2 * (100ms + 694445ns + 1750us);
  const Instant start = world_->now();
  read(victim, 1, 2, kFirst, 1, true);
  for (std::uint16_t transaction = 0; transaction < 20; ++transaction) {
    const Instant asked = world_->now();
    read(other, transaction, 3, kFirst, 1);
    world_->run(start + 1s, [&] { return oracle_.open_of(other) == 0; });
    EXPECT_LT(world_->now() - asked, 10ms);
  }
  world_->run(start + 1s, [&] { return oracle_.open() == 0; });
  EXPECT_LE(world_->now() - start, limit + 10ms);  // what was on the line when its turn came
  EXPECT_EQ(oracle_.exceptions().at(0x0B), 1U);
}

TEST_F(Traffic, AnswersOfAnotherUnitOrFunctionAreNotDelivered) {
  for (const sim::Faults& faults :
       {fault(&sim::Faults::wrong_unit), fault(&sim::Faults::wrong_function),
        fault(&sim::Faults::bad_crc)}) {
    build({bus_plan({1})});
    fill_registers();
    world_->wire(0).device(1)->set_faults(faults);
    const ClientId client = world_->connect(0, 1);
    const auto failures = oracle_.exceptions().contains(0x0B) ? oracle_.exceptions().at(0x0B) : 0;
    read(client, 1, 1, kFirst, 2, true);
    finish(world_->now() + 1s);
    EXPECT_EQ(oracle_.exceptions().at(0x0B), failures + 1);
    oracle_.forget(client);
    oracle_ = {};
  }
}

TEST_F(Traffic, AWriteToASilentDeviceIsOnTheWireOnce) {
  build({bus_plan({1})});
  world_->wire(0).device(1)->set_faults(fault(&sim::Faults::silent));
  const ClientId client = world_->connect(0, 1);
  const auto pdu = write_pdu(1, kFirst, 1);
  oracle_.expect(client, 1, {}, true);
  world_->send(client, adu(1, 1, pdu));
  world_->run_for(10s);
  EXPECT_EQ(oracle_.open(), 0U);
  EXPECT_EQ(world_->wire(0).counters().frames, 1U);
}

TEST_F(Traffic, AnUnpluggedAdapterFailsAtOnceAndServiceResumes) {
  build({bus_plan({1})});
  fill_registers();
  const ClientId client = world_->connect(0, 1);
  for (std::uint16_t transaction = 0; transaction < 10; ++transaction) {
    read(client, transaction, 1, kFirst, 5, true);
  }
  world_->run_for(3ms);  // the first one is on the wire
  world_->unplug(0);
  EXPECT_EQ(oracle_.open(), 0U);
  EXPECT_EQ(oracle_.exceptions().at(0x0B), 1U);
  EXPECT_EQ(oracle_.exceptions().at(0x0A), 9U);
  world_->run_for(1s);
  read(client, 100, 1, kFirst, 5);
  finish(world_->now() + 1s);
}

// Clients that pipeline, split, half-close and vanish; drives that are silent, slow, damaged or
// strange; an adapter that is pulled out. Every surviving request is answered once, no answer is
// another's, no write is on the wire twice, and when the faults stop everything finishes.
class Seeds : public Traffic, public testing::WithParamInterface<unsigned> {
 protected:
  void disturb() {
    const auto units = units_[0];
    auto& drive = *world_->wire(0).device(units[random_() % units.size()]);
    switch (random_() % 6) {
      case 0: drive.set_faults(fault(&sim::Faults::silent)); break;
      case 1: drive.set_faults(fault(&sim::Faults::bad_crc)); break;
      case 2: drive.set_faults(fault(&sim::Faults::wrong_unit)); break;
      case 3: drive.set_faults(exceptions_every(3)); break;
      case 4: world_->unplug(random_() % 2); break;
      default: drive.set_faults({}); break;
    }
  }
  void act(ClientId client, std::size_t bus) {
    const auto transaction = next_transaction_++;
    switch (random_() % 12) {
      case 0: {
        const std::uint8_t unit = units_[bus][random_() % units_[bus].size()];
        const auto offset = static_cast<std::uint16_t>(random_() % kRegisters);
        const auto pdu = write_pdu(unit, static_cast<std::uint16_t>(kFirst + offset), 1);
        oracle_.expect(client, transaction, adu(transaction, unit, {pdu.begin(), pdu.begin() + 5}),
                       true);
        world_->send(client, adu(transaction, unit, pdu));
        ++writes_[{bus, {unit, address_of(pdu)}}];
        break;
      }
      case 1: world_->run_for(std::chrono::milliseconds(random_() % 200)); break;
      default: random_read(client, bus, transaction, true);
    }
  }
  std::uint16_t next_transaction_ = 0;
  /// How often each register of each drive was written, by bus and unit.
  using Writes = std::map<std::pair<std::size_t, std::pair<std::uint8_t, unsigned>>, int>;
  static unsigned address_of(const std::vector<std::uint8_t>& pdu) {
    return modbus::load_be16(pdu, 1);
  }
  Writes writes_;
};

TEST_P(Seeds, EveryRequestIsAnsweredOnceAndAsAsked) {
  random_.seed(GetParam());
  build({bus_plan({1, 2, 3}), bus_plan({4, 5}, modbus::Baud{19200})});
  fill_registers();
  const std::uint64_t filled =
      world_->wire(0).counters().frames + world_->wire(1).counters().frames;
  std::vector<std::pair<ClientId, std::size_t>> clients;
  for (unsigned number = 0; number < 8; ++number) {
    clients.emplace_back(world_->connect(number % 2, number), number % 2);
  }
  for (int round = 0; round < 300; ++round) {
    auto& [client, bus] = clients[random_() % clients.size()];
    act(client, bus);
    if (random_() % 20 == 0) {
      disturb();
    }
    if (random_() % 40 == 0) {
      oracle_.forget(client);
      world_->disconnect(client);
      client = world_->connect(bus, static_cast<unsigned>(random_() % 8));
    }
  }
  for (const std::uint8_t unit : units_[0]) {
    world_->wire(0).device(unit)->set_faults({});
  }
  finish(world_->now() + 5min);
  EXPECT_EQ(world_->silence_violations(), 0U);
  const std::uint64_t frames =
      world_->wire(0).counters().frames + world_->wire(1).counters().frames;
  EXPECT_GT(frames, filled);
  for (std::size_t bus = 0; bus < 2; ++bus) {
    for (const auto& frame : world_->wire(bus).frames()) {
      if (frame.bytes.at(1) == 0x10 && frame.bytes.at(5) == 1) {
        --writes_[{bus, {frame.bytes[0], modbus::load_be16(frame.bytes, 2)}}];
      }
    }
  }
  for (const auto& [where, left] : writes_) {
    EXPECT_GE(left, 0) << "a write of unit " << unsigned{where.second.first} << " was repeated";
  }
  world_->run_for(6s);                                       // adapters are back by then
  random_read(clients[0].first, clients[0].second, 60'000);  // and service is as before
  finish(world_->now() + 1min);
}

INSTANTIATE_TEST_SUITE_P(Simulation, Seeds, testing::Range(1U, 51U));

}  // namespace
}  // namespace mbgate::test

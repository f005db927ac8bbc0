// SPDX-License-Identifier: Apache-2.0
// Gateway and drives in virtual time: much traffic, and what goes wrong on a line.
#include "simulation/traffic.hpp"

namespace mbgate::test {
namespace {

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
  read(victim, 1, {2, kFirst, 1}, true);
  for (std::uint16_t transaction = 0; transaction < 20; ++transaction) {
    const Instant asked = world_->now();
    read(other, transaction, {3, kFirst, 1});
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
    read(client, 1, {1, kFirst, 2}, true);
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
    read(client, transaction, {1, kFirst, static_cast<std::uint16_t>(transaction + 1)}, true);
  }
  world_->run_for(3ms);  // the first one is on the wire
  world_->unplug(0);
  EXPECT_EQ(oracle_.open(), 0U);
  EXPECT_EQ(oracle_.exceptions().at(0x0B), 1U);
  EXPECT_EQ(oracle_.exceptions().at(0x0A), 9U);
  world_->run_for(1s);
  read(client, 100, {1, kFirst, 5});
  finish(world_->now() + 1s);
}

}  // namespace
}  // namespace mbgate::test

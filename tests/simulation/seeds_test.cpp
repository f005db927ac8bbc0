// SPDX-License-Identifier: Apache-2.0
// Faults by chance, each run reproducible from its seed.
#include "simulation/traffic.hpp"

namespace mbgate::test {
namespace {

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
  clients.reserve(8);
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

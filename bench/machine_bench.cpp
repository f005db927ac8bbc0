// SPDX-License-Identifier: Apache-2.0
// The hot path alone, in virtual time: a request comes in as Modbus TCP, goes out as RTU, and its
// response comes back, through the very machine that mbgated runs. Counts how often memory is asked
// for on the way.
#include <benchmark/benchmark.h>

#include <optional>
#include <utility>
#include <vector>

#include "counted_new.hpp"
#include "modbus/frames.hpp"
#include "plant.hpp"
#include "support/gateway_harness.hpp"

namespace mbgate::bench {
namespace {

using bus::Instant;
using namespace std::chrono_literals;

gateway::Settings settings() {
  gateway::Settings settings;
  settings.listeners.emplace_back().name = "plant";
  auto& line = settings.buses.emplace_back();
  line.name = "line-a";
  line.line.device = "/dev/ttyS0";
  line.listen_first = 0ms;
  auto& route = settings.routes.emplace_back();
  route.first_unit = route.first_address = 1;
  route.last_unit = 247;
  route.buses = {gateway::BusId{0}};
  return settings;
}

/// A machine with a line and clients that each have one request outstanding.
class Machine {
 public:
  Machine(unsigned clients, unsigned registers)
      : harness_(settings(), Instant(1s)), registers_(registers) {
    drain();
    feed(gateway::LineOpened{gateway::BusId{0}});
    for (unsigned client = 0; client < clients; ++client) {
      const auto rtu = make_request(1 + client % 4, client * registers, registers);
      Frame adu{0, 0, 0, 0, 0, 6};
      adu.insert(adu.end(), rtu.begin(), rtu.end() - 2);
      requests_.push_back(std::move(adu));
      responses_.push_back(answer(0, rtu));
      feed(gateway::ClientConnected{
          gateway::ClientId{client},
          {gateway::ListenerId{0}, *routing::ClientAddress::parse("192.0.2.1")}});
      ask(client);
    }
  }

  /// Until one more client has its answer, and has asked again.
  void transact() {
    const std::uint64_t before = answers_;
    while (answers_ == before) {
      harness_.wake();
      drain();
      if (transmitted_) {
        transmitted_ = false;
        harness_.go_on(harness_.now() + 10ms);
        feed(gateway::LineBytes{gateway::BusId{0}, responses_.at(asked_)});
      }
    }
    ask(answered_);
  }

 private:
  void ask(std::size_t client) {
    feed(gateway::ClientBytes{gateway::ClientId{client}, requests_[client]});
  }

  void feed(const gateway::Input& input) {
    harness_.handle(input);
    drain();
  }

  void drain() {
    harness_.drain([this](const gateway::Action& action) { take(action); });
    if (sent_) {
      feed(gateway::ClientSent{*std::exchange(sent_, std::nullopt)});
    }
  }

  void take(const gateway::Action& action) {
    if (const auto* look = std::get_if<gateway::Look>(&action)) {
      harness_.handle(gateway::LineLooked{look->bus});
    } else if (const auto* frame = std::get_if<gateway::Transmit>(&action)) {
      transmitted_ = true;
      asked_ = modbus::load_be16(modbus::Bytes(frame->frame), 2) / registers_;
    } else if (const auto* answer = std::get_if<gateway::Send>(&action)) {
      ++answers_;
      answered_ = static_cast<std::size_t>(answer->client);
      sent_ = answer->client;
    }
  }

  test::GatewayHarness harness_;
  unsigned registers_;  ///< of each client, one client's behind the other's
  std::vector<Frame> requests_;
  std::vector<Frame> responses_;
  std::optional<gateway::ClientId> sent_;
  std::uint64_t answers_ = 0;
  std::size_t answered_ = 0;
  std::size_t asked_ = 0;
  bool transmitted_ = false;
};

/// Arguments: clients, registers.
void transaction(benchmark::State& state) {
  Machine machine(static_cast<unsigned>(state.range(0)), static_cast<unsigned>(state.range(1)));
  for (int warm_up = 0; warm_up < 10'000; ++warm_up) {
    machine.transact();
  }
  const std::uint64_t before = allocations();
  while (state.KeepRunning()) {
    machine.transact();
  }
  state.counters["allocations"] = benchmark::Counter(static_cast<double>(allocations() - before),
                                                     benchmark::Counter::kAvgIterations);
}
BENCHMARK(transaction)
    ->ArgNames({"clients", "registers"})
    ->ArgsProduct({{1, 8, 256}, {1, 10, 125}});

void crc(benchmark::State& state) {
  const Frame frame(static_cast<std::size_t>(state.range(0)), 0x5A);
  while (state.KeepRunning()) {
    benchmark::DoNotOptimize(modbus::crc16(frame));
  }
}
BENCHMARK(crc)->ArgName("bytes")->Arg(6)->Arg(253);

}  // namespace
}  // namespace mbgate::bench

BENCHMARK_MAIN();

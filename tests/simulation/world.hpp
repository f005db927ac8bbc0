// SPDX-License-Identifier: Apache-2.0
// The whole plant in virtual time: the product's own Gateway, simulated buses with drives, and
// clients that the test plays. Nothing waits for a clock; the same calls give the same run.
#pragma once

#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "sim/wire/tcp_bus.hpp"
#include "sim/wire/wire.hpp"
#include "support/gateway_harness.hpp"

namespace mbgate::test {

using namespace std::chrono_literals;
using bus::Duration;
using bus::Instant;
using gateway::BusId;
using gateway::ClientId;
using gateway::ListenerId;

struct BusPlan {
  bus::BusSettings bus;
  std::vector<sim::DeviceSettings> devices;
};

class World {
 public:
  /// `on_answer` is called with every ADU that a client receives.
  using OnAnswer = std::function<void(ClientId, modbus::Bytes)>;

  /// One transparent listener for each bus.
  World(const std::vector<BusPlan>& buses, OnAnswer on_answer);
  /// The same with settings of the test's own; `devices` are those on each bus.
  World(const gateway::Settings& settings,
        const std::vector<std::vector<sim::DeviceSettings>>& devices, OnAnswer on_answer);

  ClientId connect(std::size_t listener, unsigned host);
  void send(ClientId client, modbus::Bytes bytes);
  void disconnect(ClientId client);
  void reload(const gateway::Settings& settings) { feed(gateway::SettingsChanged{&settings}); }
  void clear_counters() { feed(gateway::ClearCountersAsked{}); }

  /// Runs until nothing is left to happen before `limit`, or `done` says so.
  void run(Instant limit, const std::function<bool()>& done);
  void run_for(Duration duration) {
    run(now() + duration, [] { return false; });
  }

  [[nodiscard]] Instant now() const { return harness_.now(); }
  [[nodiscard]] sim::Wire& wire(std::size_t bus) { return wires_[bus]; }
  [[nodiscard]] gateway::Gateway& gateway() { return harness_.gateway(); }
  [[nodiscard]] bool is_closed(ClientId client) const { return closed_.contains(client); }
  [[nodiscard]] std::uint64_t silence_violations() const;
  [[nodiscard]] std::uint64_t collisions() const;

 private:
  void feed(const gateway::Input& input);
  void drain();
  void take(const gateway::Action& action);
  void step();
  [[nodiscard]] std::optional<Instant> next_event() const;

  OnAnswer on_answer_;
  GatewayHarness harness_;
  std::deque<sim::Wire> wires_;
  std::deque<std::optional<sim::TcpBus>> servers_;  ///< in place of the wire of a TCP bus
  std::map<ClientId, bool> closed_;
  std::uint64_t clients_ = 0;
};

}  // namespace mbgate::test

// SPDX-License-Identifier: Apache-2.0
// The whole plant in virtual time: the product's own Gateway, simulated buses with drives, and
// clients that the test plays. Nothing waits for a clock; the same calls give the same run.
#pragma once

#include <deque>
#include <functional>
#include <random>
#include <vector>

#include "sim/wire/wire.hpp"
#include "support/gateway_harness.hpp"

namespace mbgate::test {

using namespace std::chrono_literals;
using bus::Duration;
using bus::Instant;
using gateway::BusId;
using gateway::ClientId;

class World {
 public:
  /// `on_answer` is called with every ADU that a client receives.
  using OnAnswer = std::function<void(ClientId, modbus::Bytes)>;

  /// `devices` are those on each bus.
  World(const gateway::Settings& settings,
        const std::vector<std::vector<sim::DeviceSettings>>& devices, OnAnswer on_answer);

  ClientId connect(std::size_t listener, unsigned host);
  void send(ClientId client, modbus::Bytes bytes);

  /// Runs until nothing is left to happen before `limit`, or `done` says so.
  void run(Instant limit, const std::function<bool()>& done);
  void run_for(Duration duration) {
    run(now() + duration, [] { return false; });
  }

  [[nodiscard]] Instant now() const { return harness_.now(); }
  [[nodiscard]] sim::Wire& wire(std::size_t bus) { return wires_[bus]; }
  [[nodiscard]] std::uint64_t silence_violations() const;

 private:
  void feed(const gateway::Input& input);
  void drain();
  void take(const gateway::Action& action);
  [[nodiscard]] std::optional<Instant> next_event() const;

  OnAnswer on_answer_;
  GatewayHarness harness_;
  std::deque<sim::Wire> wires_;
  std::uint64_t clients_ = 0;
};

}  // namespace mbgate::test

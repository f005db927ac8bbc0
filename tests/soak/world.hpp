// SPDX-License-Identifier: Apache-2.0
// One seed: the product's own gateway, its wires and its clients in virtual time. First a time of
// faults until enough transmissions were seen, then a quiet one in which everything must finish.
#pragma once

#include <memory>
#include <variant>

#include "soak/client.hpp"
#include "soak/far_server.hpp"
#include "soak/serial_wire.hpp"

namespace mbgate::soak {

class World {
 public:
  explicit World(std::uint64_t seed, bool trace = false);
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// The whole run, until `transmissions` were seen and everything is over.
  Report run(std::uint64_t transmissions);

 private:
  using Wire = std::variant<SerialWire, FarServer>;
  struct BusState {
    bool open = false;
    Instant away_until = Instant::min();
    std::uint64_t epoch = 0;
  };

  void trace(const std::string& text) const;
  static Oracle::Devices make_devices(const SoakPlan& plan, Random& random);
  bool step();
  void run_until(Instant limit);
  void drain();
  void carry_out(const gateway::Action& action);
  void open(std::size_t bus);
  void lose(std::size_t bus);
  void begin_losses(std::size_t bus);
  void deliver(std::size_t bus, Bytes bytes);
  void transmit(std::size_t bus, Bytes frame);
  Client* find(ClientId number);
  void calm_down();
  void check_back();
  void check_counters();
  void check_overdue_often();

  Random random_;
  SoakPlan plan_;
  Report report_;
  Schedule schedule_;
  Oracle::Devices devices_;
  Oracle oracle_;
  Asking asking_;
  Surroundings around_;
  std::deque<Wire> wires_;
  std::vector<BusState> buses_;
  gateway::Gateway gateway_;
  Client::Tools tools_;
  std::deque<Client> clients_;
  std::map<ClientId, Client*> numbers_;
  std::uint64_t last_number_ = 0;
  bool trouble_ = true;
  bool draining_ = false;
  bool trace_;
  unsigned steps_in_place_ = 0;  ///< since time last went on
};

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
// One seed: the product's own gateway, its wires and its clients in virtual time. First a time of
// faults until enough transmissions were seen, then a quiet one in which everything must finish.
#pragma once

#include <deque>
#include <memory>
#include <set>
#include <variant>

#include "soak/client.hpp"
#include "soak/far_server.hpp"
#include "soak/from_world.hpp"
#include "soak/hang_watch.hpp"
#include "soak/reload.hpp"
#include "soak/serial_wire.hpp"

namespace mbgate::soak {

class World {
 public:
  explicit World(std::uint64_t seed, bool trace = false);
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// From now on its driver judges before it reads, which the oracle must see.
  void break_promise() { driver_.break_promise(); }
  /// The whole run, until `transmissions` were seen and everything is over.
  Report run(std::uint64_t transmissions);

 private:
  using Wire = std::variant<SerialWire, FarServer>;
  /// How a line that the process still has has ended.
  enum class End : std::uint8_t { lost, closed, closed_after_answers };
  struct BusState {
    bool open = false;  ///< there is an adapter, and the process has it
    End end = End::lost;
    Instant away_until = Instant::min();
    std::uint64_t epoch = 0;
    bool framing_lost = false;  ///< the gateway must close it
  };

  void trace(const std::string& text) const;
  static Oracle::Devices make_devices(const SoakPlan& plan, Random& random);
  [[nodiscard]] bool makes_progress(const char* busy_with);
  bool step();
  void run_until(Instant limit);
  void interrupt(Duration time);
  void stalled(Duration missed);
  Driver::Hands hands();
  void drain();
  [[nodiscard]] bool take(const gateway::Action& action);
  void carry_out(const gateway::Action& action);
  void open(std::size_t bus);
  void swap_adapter(std::size_t bus);
  void opened(std::size_t bus, bool refused);
  void lose(std::size_t bus);
  void hang_up(std::size_t bus, bool answered);
  void shut(std::size_t bus);
  void lost(std::size_t bus);
  void begin_losses(std::size_t bus);
  void deliver(std::size_t bus, const std::vector<std::uint8_t>& bytes);
  void hand_in(std::size_t bus, Bytes bytes);
  void begin_reloads();
  void reload(const Reload& reload, const std::vector<bool>& absent);
  void take_effect(const Reload& reload, const std::vector<bool>& absent);
  void object(std::size_t bus, const std::string& objection) const;
  void check_report(const gateway::Event& event);
  void check_order_only(const gateway::Action& action);
  void restore();
  // world_restart.cpp
  void begin_restarts();
  void restart();
  [[nodiscard]] gateway::BusId id_of(std::size_t bus) const {
    return gateway::BusId{static_cast<std::uint32_t>(bus)};
  }
  void transmit(std::size_t bus, Bytes frame);
  Client* find(ClientId number);
  void come_to_rest();
  void calm_down();
  void shut_down();
  void check_back();
  void check_counters();
  void check_head(Client& client);
  void check_bus(Client& client, std::size_t bus);
  void check_device(Client& client, std::size_t index);
  void compare_ends(const std::string& name, std::uint64_t responses, std::uint64_t timeouts,
                    std::uint64_t bad_crcs, const BusCount& count);
  const PduBytes& own_registers(Client& client, std::size_t first, std::size_t count);
  void compare(const std::string& what, std::uint64_t shown, std::uint64_t least,
               std::uint64_t most);
  void compare(const std::string& what, std::uint64_t shown, std::uint64_t seen) {
    compare(what, shown, seen, seen);
  }
  void check_overdue_often();
  void clear_counters_some_time();

  Random random_;
  Random swaps_;  // of adapters
  Random restarts_;
  SoakPlan plan_;
  Report report_;
  Schedule schedule_;
  Oracle::Devices devices_;
  Oracle oracle_;
  Asking asking_;
  Surroundings around_;
  std::deque<Wire> wires_;
  std::vector<BusState> buses_;
  HangWatch hangs_;
  Reloads reloads_;
  std::set<std::size_t> shut_due_;  // lines that the gateway gives up because of a reload
  std::set<ClientId> close_due_;    // and connections
  bool order_only_ = false;         // the actions are those to a reload that changes nothing
  test::GatewayHarness harness_;    ///< its time is the schedule's
  Driver driver_;
  Client::Tools tools_;
  std::deque<Client> clients_;
  std::uint64_t last_number_ = 0;
  bool trouble_ = true;
  bool draining_ = false;
  bool is_stopping_ = false;
  Instant end_ = Instant::max();  ///< of its time to stop
  Crowded full_;
  std::deque<gateway::Action> frames_;  ///< to be transmitted when nothing else is to be done
  std::size_t carried_out_ = 0;         ///< since the last input: nothing delays a frame behind it
  bool trace_;
  Instant place_ = Instant::min();
  unsigned done_in_place_ = 0;  ///< since then
  bool counters_cleared_ = false;
  bool stuck_ = false;  ///< it makes no progress: the run is over
};

}  // namespace mbgate::soak

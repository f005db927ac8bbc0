// SPDX-License-Identifier: Apache-2.0
// One seed: the product's own gateway, its wires and its clients in virtual time. First a time of
// faults, then a calm one in which everything must come back.
#pragma once

#include <variant>

#include "world/client.hpp"
#include "world/line.hpp"
#include "world/server.hpp"

namespace mbgate::world {

/// Who judges: it is told after each thing that was noted in the ledger.
struct Witness {
  virtual ~Witness() = default;
  virtual void asked(Id /*asked*/) {}
  virtual void given(Id /*asked*/) {}
  virtual void answered(Id /*asked*/) {}
  virtual void sent(Id /*sent*/) {}
  virtual void came(std::size_t /*bus*/) {}
  virtual void gone(Id /*connection*/) {}
  virtual void reloaded() {}  ///< the plan has other settings from now on
};

class World {
 public:
  World(Plan plan, bool trace);
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  void be_watched_by(Witness& witness) { witness_ = &witness; }
  /// Goes on until so many transmissions were seen, or requests beyond reason.
  void run(std::uint64_t transactions);
  void run_for(Duration time) { run_until(schedule_.now() + time); }
  /// Faults stop, and nobody asks for anything new; what was asked ends.
  void come_to_rest();
  /// A client that asks this, and waits; none: it got no answer in time.
  std::optional<Octets> ask(std::size_t door, Duration patience);
  /// The same of the gateway's own unit.
  std::optional<Octets> ask_gateway(const Octets& pdu, Duration patience);
  /// A client that asks nothing by itself.
  Client& visit(std::size_t listener, unsigned host);
  /// Other settings, as another file would have them; the plan keeps its own.
  void change(const gateway::Settings& settings);
  void shut_down();
  /// Its driver judges before it reads, which it must not.
  void break_promise() { driver_.break_promise(); }
  /// A serial line hangs, until it is opened again at least.
  void hang(std::size_t bus) { std::get<Line>(wires_[bus]).hang(); }
  /// The drive has none for so long.
  void take_supply(std::size_t drive, Duration time) { drives_[drive].lose_supply(now() + time); }

  [[nodiscard]] const Plan& plan() const { return plan_; }
  [[nodiscard]] const Ledger& ledger() const { return ledger_; }
  [[nodiscard]] const std::vector<Drive>& drives() const { return drives_; }
  /// From now on.
  [[nodiscard]] Habits& habits_of(std::size_t drive) { return drives_[drive].habits; }
  [[nodiscard]] const std::vector<gateway::Event>& events() const { return events_; }
  [[nodiscard]] Report& report() { return report_; }
  [[nodiscard]] Instant now() const { return schedule_.now(); }
  [[nodiscard]] bool is_finished() const { return finished_; }
  [[nodiscard]] const gateway::Gateway& gateway() { return harness_->gateway(); }

 private:
  using Wire = std::variant<Line, Server>;
  struct BusState {
    std::uint32_t id = 0;  ///< as the gateway numbers it
    bool open = false;     ///< the process has it
    Instant away_until = Instant::min();
    std::uint64_t epoch = 0;
    std::size_t unsent = 0;  ///< as the gateway was told
  };

  void trace(const std::string& text) const;
  bool step();
  void run_until(Instant limit);
  Driver::Hands hands();
  void hand_in(const gateway::Input& input);
  void drain();
  void carry_out(const gateway::Action& action);
  void transmit(std::size_t bus, Octets frame);
  Sent read_frame(std::size_t bus, Bytes frame);
  void note_sent(Id id);
  void open(std::size_t bus);
  void opened(std::size_t bus, bool refused);
  void shut(std::uint32_t id);
  void close_line(std::size_t bus);
  void deliver(std::size_t bus, const Octets& bytes, const Came& came);
  void tell_unsent(std::size_t bus);
  void begin_losses(std::size_t bus);
  void lose(std::size_t bus, bus::Loss loss);
  void given(Id asked);
  void answered(Id asked);
  std::optional<Octets> ask(std::size_t listener, Intent intent, Duration patience);
  template <typename ForClient>
  [[nodiscard]] Client* find(const ForClient* action);
  [[nodiscard]] std::optional<std::size_t> bus_of(gateway::BusId id) const;
  // world_changes.cpp
  void again(Duration every, void (World::*event)());
  void restart();
  void reload();
  void hand_in_settings(const gateway::Settings& settings);
  void rename_devices();
  void change_settings();
  void change_meaning();
  void take_rights();
  void outdate(std::size_t door);
  void number_buses();

  Plan plan_;
  Random random_;
  Random changes_;
  Random rights_;
  Schedule schedule_;
  Ledger ledger_;
  Report report_;
  std::vector<Drive> drives_;
  Surroundings around_;
  std::deque<Wire> wires_;
  std::vector<BusState> buses_;
  std::optional<test::GatewayHarness> harness_;
  Driver driver_;
  Asking asking_;
  ClientTools tools_;
  std::deque<Client> clients_;
  Witness nobody_;
  Witness* witness_ = &nobody_;
  std::vector<bus::Loss> losses_;       ///< by bus, of what the driver will find
  std::vector<gateway::Event> events_;  ///< that the gateway has reported
  bool trace_;
  bool draining_ = false;
  bool finished_ = false;
  bool stuck_ = false;
  Instant place_ = Instant::min();
  unsigned done_in_place_ = 0;
};

}  // namespace mbgate::world

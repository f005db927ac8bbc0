// SPDX-License-Identifier: Apache-2.0
// Drills: small plants in which one thing goes wrong at a time, by a plan. So the judge knows
// exactly what has to come of it: how often the gateway tries, when, what it counts and what it
// says (promise 7 in docs/behaviour.md). What varies is drawn from the seed.
#pragma once

#include "judge/judge.hpp"
#include "judge/rules_judge.hpp"

namespace mbgate::judge {

/// The drill of this seed.
world::Report drill(std::uint64_t seed, bool trace);

/// A plant of one line and a few drives behind one transparent listener, and what is expected of
/// it.
class Drill {
 public:
  Drill(std::uint64_t seed, unsigned drives);

  // Before begin():
  [[nodiscard]] Plan& plan() { return plan_; }
  [[nodiscard]] Random& random() { return random_; }
  [[nodiscard]] drive::DeviceTiming& timing(std::size_t at) {
    return plan_.settings.devices[at].timing;
  }
  void begin(bool trace);

  [[nodiscard]] World& world() { return *world_; }
  [[nodiscard]] const Ledger& ledger() { return world_->ledger(); }
  [[nodiscard]] Instant now() { return world_->now(); }
  void wait(Duration time) { world_->run_for(time); }
  [[nodiscard]] Intent intent(Kind kind, std::size_t door, Octets pdu);
  /// Puts it into the client's socket, and goes on after so long. The first doors are those of the
  /// stations.
  Id ask(Client& client, Intent intent, Duration patience = Duration{0});
  Id read(Client& client, std::size_t door, Duration patience = Duration{0}, unsigned count = 4);
  Id write(Client& client, std::size_t door, Duration patience = Duration{0});
  Id stop(Client& client, std::size_t door, std::uint16_t word, Duration patience = Duration{0});
  Octets own(Client& client, const Octets& pdu) {
    return ledger()
        .asked[ask(client, Asking::of_gateway(pdu), std::chrono::milliseconds(10))]
        .answer;
  }
  Client& visit(unsigned host) { return world_->visit(0, host); }
  /// "": none yet, "ok", or the exception in hexadecimal.
  std::string outcome(Id asked);
  /// Since the last call.
  std::vector<Id> transmissions();
  gateway::BusStatus bus();
  gateway::DeviceStatus device(std::size_t station);
  /// Of devices, since the beginning.
  std::size_t notices(bus::DeviceNotice::Kind kind, std::size_t station);
  /// How long one transmission to the station and the wait for its answer take at most.
  Duration longest(std::size_t station);

  void expect(const char* what, bool is_so, const std::string& text = "");
  template <typename Value>
  void equal(const char* what, Value is, Value must) {
    expect(what, is == must, std::to_string(is) + ", must be " + std::to_string(must));
  }
  void between(const char* what, Duration is, Duration least, Duration most);
  world::Report end();

 private:
  static constexpr std::uint64_t kDrillsChance = 0x4452494CULL;

  Plan plan_;
  Random random_;
  std::optional<World> world_;
  std::optional<Judge> judge_;
  std::optional<RulesJudge> rules_;
  std::size_t seen_ = 0;
  unsigned words_ = 0;
};

// The drills: each makes its plant, and expects what the contract says of it.
void drill_silence(Drill& drill, bool trace);
void drill_damage(Drill& drill, bool trace);
void drill_lateness(Drill& drill, bool trace);
void drill_hold(Drill& drill, bool trace);
void drill_seconds(Drill& drill, bool trace);
void drill_room(Drill& drill, bool trace);
void drill_turns(Drill& drill, bool trace);
void drill_sharing(Drill& drill, bool trace);
void drill_quiet(Drill& drill, bool trace);
void drill_noise(Drill& drill, bool trace);
void drill_crawl(Drill& drill, bool trace);
void drill_misfits(Drill& drill, bool trace);
void drill_stranger(Drill& drill, bool trace);
void drill_stop_first(Drill& drill, bool trace);
void drill_stop_fails(Drill& drill, bool trace);
void drill_old_echo(Drill& drill, bool trace);
void drill_reload(Drill& drill, bool trace);
void drill_failsafe(Drill& drill, bool trace);

}  // namespace mbgate::judge

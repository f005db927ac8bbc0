// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>

#include "judge/meter.hpp"
#include "judge/run.hpp"

namespace mbgate::judge {
namespace {

constexpr Duration kStart = 10s;  // it has listened, and asked everybody
constexpr Duration kRun = 120s;
constexpr unsigned kPoller = 0;  // hosts
constexpr unsigned kOther = 1;
constexpr unsigned kWriter = 2;

double seconds(Duration time) { return std::chrono::duration<double>(time).count(); }

/// One line at 19200 baud behind a transparent listener; at the last addresses is nobody.
Plan make_plant(unsigned drives, unsigned nobody) {
  Plan plan;
  plan.seed = 1;
  auto& bus = plan.settings.buses.emplace_back();
  bus.name = "line";
  bus.line.device = "/dev/ttyS0";
  plan.lines.emplace_back().kind = bus::LineKind::uart;
  auto& listener = plan.settings.listeners.emplace_back();
  listener.name = "clients";
  listener.bus = drive::BusId{0};
  for (unsigned at = 0; at < drives + nobody; ++at) {
    Station station{0, low(at + 1), {}, {}, false, false};
    if (at < drives) {
      auto& device = plan.settings.devices.emplace_back();
      device.name = "drive-" + std::to_string(at + 1);
      device.bus = drive::BusId{0};
      device.address = low(at + 1);
      device.word_order = drive::WordOrder::big;
      device.profile.stops.push_back({Table::holding_registers, kStopRegister, 0xF000, 0x5000});
      device.profile.stops.push_back({Table::holding_registers, kOtherStop, 0xF000, 0x4000});
      station.device = at;
      station.drives = {at};
      plan.drives.emplace_back().habits.quick = 5ms;
    }
    plan.stations.push_back(station);
    Door door;
    door.unit = station.address;
    door.station = at;
    plan.doors.push_back(door);
  }
  plan.readers.resize(1);
  plan.writers.resize(plan.settings.devices.size());
  plan.settings.guards.resize(plan.settings.devices.size());
  return plan;
}

/// It asks again as soon as it is answered.
Manners& add_client(Plan& plan, unsigned host, std::vector<std::size_t> stations) {
  Manners& manners = plan.clients.emplace_back();
  manners.host = host;
  manners.pause = 1ms;
  manners.same_reads = 1000;
  manners.plain = true;
  manners.stations = std::move(stations);
  return manners;
}

void add_writer(Plan& plan) {
  Manners& writer = add_client(plan, kWriter, {0});
  writer.writes = 1000;
  writer.pause = 500ms;
}

class Figures {
 public:
  void add(const std::string& what, const std::string& figure, const std::string& goal, bool kept,
           bool was_kept) {
    std::printf("%-44s %-34s %-34s %s\n", what.c_str(), figure.c_str(), goal.c_str(),
                kept       ? "ok"
                : was_kept ? "MISSES, kept until now"
                           : "MISSES");
    sound_ = sound_ && (kept || !was_kept);
  }
  [[nodiscard]] bool is_sound() const { return sound_; }

 private:
  bool sound_ = true;
};

std::string text(const char* form, double value) {
  std::array<char, 64> buffer{};
  std::snprintf(buffer.data(), buffer.size(), form, value);
  return buffer.data();
}

/// A plant after its start, and what is measured in it.
struct Trial {
  explicit Trial(Plan plan) : world(std::move(plan), false), meter(world) {
    world.be_watched_by(meter);
    world.run_for(kStart);
  }
  void measure(Duration time) {
    meter.begin();
    world.run_for(time);
  }

  World world;
  Meter meter;
};

unsigned rate_alone() {
  Plan plan = make_plant(1, 0);
  add_client(plan, kPoller, {0});
  Trial trial(std::move(plan));
  trial.measure(kRun);
  return trial.meter.good[kPoller];
}

// (a) and (b): reads and writes of a drive that is well, beside others that are polled, from when
// these have lost their supply.
void beside_dead_drives(Figures& table, unsigned dead, unsigned alone) {
  constexpr double kShare = 0.45;
  constexpr Duration kLongest = 1s + 200ms;
  Plan plan = make_plant(1 + dead, 0);
  add_client(plan, kPoller, {0});
  for (std::size_t at = 1; at <= dead; ++at) {
    add_client(plan, kOther, {at});
  }
  add_writer(plan);
  Trial trial(std::move(plan));
  trial.meter.begin();
  for (std::size_t at = 1; at <= dead; ++at) {
    trial.world.take_supply(at, 2 * kRun);
  }
  trial.world.run_for(kRun);
  const double share = static_cast<double>(trial.meter.good[kPoller]) / alone;
  const std::string beside = " beside " + std::to_string(dead) + " dead drives";
  table.add("(a) reads" + beside, text("%.0f %% of the line", 100 * share), "45 %", share >= kShare,
            true);
  table.add("(b) writes" + beside,
            std::to_string(trial.meter.refused_writes) + " of " +
                std::to_string(trial.meter.writes) + " refused, longest " +
                text("%.2f s", seconds(trial.meter.longest_write)),
            "none refused, 1.2 s",
            trial.meter.refused_writes == 0 && trial.meter.longest_write <= kLongest, true);
}

// (c): as many connections as one likes, the hosts get alike.
void shares_of_hosts(Figures& table) {
  constexpr unsigned kHosts = 4;
  Plan plan = make_plant(kHosts, 0);
  for (unsigned host = 0; host < kHosts; ++host) {
    for (unsigned count = 0; count < 1U << host; ++count) {
      add_client(plan, host, {host});
    }
  }
  plan.settings.buses.front().coalesce = false;
  Trial trial(std::move(plan));
  trial.measure(kRun / 4);
  unsigned least = ~0U;
  unsigned most = 0;
  for (const auto& [host, count] : trial.meter.good) {
    least = std::min(least, count);
    most = std::max(most, count);
  }
  const double spread = static_cast<double>(most) / std::max(least, 1U) - 1;
  table.add("(c) hosts with 1, 2, 4 and 8 connections", text("%.1f %% apart", 100 * spread), "10 %",
            spread <= 0.1, true);
  table.add("(f) the wire is idle while work waits",
            text("%.3f ms at most", 1000 * seconds(trial.meter.longest_idle)), "0.1 ms",
            trial.meter.longest_idle <= 100us, true);
}

// (d): they lose their supply together, and get it back together.
void time_until_back(Figures& table, unsigned drives, bool was_kept) {
  constexpr Duration kDark = 60s;
  Plan plan = make_plant(drives, 0);
  for (std::size_t at = 0; at < drives; ++at) {
    add_client(plan, kPoller, {at});
  }
  Trial trial(std::move(plan));
  for (std::size_t at = 0; at < drives; ++at) {
    trial.world.take_supply(at, kDark);
  }
  trial.world.run_for(kDark);
  trial.meter.begin();
  const Instant back = trial.world.now();
  trial.world.run_for(10s);
  const Instant all = trial.meter.all_back();
  table.add("(d) " + std::to_string(drives) + " drives are back, all served",
            all == kNever ? "never" : text("after %.2f s", seconds(all - back)), "3 s",
            all <= back + 3s, was_kept);
}

// (e): somebody asks all addresses, most of which nobody has.
void beside_a_scan(Figures& table, unsigned alone) {
  constexpr unsigned kAddresses = 200;
  Plan plan = make_plant(1, kAddresses);
  add_client(plan, kPoller, {0});
  std::vector<std::size_t> all;
  for (std::size_t at = 1; at <= kAddresses; ++at) {
    all.push_back(at);
  }
  add_client(plan, kOther, all);
  Trial trial(std::move(plan));
  trial.measure(kRun);
  const double share = static_cast<double>(trial.meter.good[kPoller]) / alone;
  table.add("(e) a poller beside a scan", text("%.0f %% of its rate", 100 * share), "40 %",
            share >= 0.4, true);
}

// (g): nothing comes and nothing goes until the line is opened again, which mostly helps.
void hung_under_stops(Figures& table, unsigned clients, bool was_kept) {
  constexpr unsigned kWorlds = 3;
  std::vector<Duration> longest;
  Duration hung_after{0};
  for (unsigned seed = 1; seed <= kWorlds; ++seed) {
    Plan plan = make_plant(clients, 0);
    plan.seed = seed;
    plan.settings.buses.front().line.echo = false;  // else nothing but a read shows what comes
    for (unsigned host = 0; host < clients; ++host) {
      add_client(plan, host, {host}).stops = 1000;
    }
    hung_after = plan.settings.buses.front().hung_after;
    Trial trial(std::move(plan));
    trial.meter.begin();
    trial.world.hang(0);
    trial.world.run_for(kRun);
    longest.push_back(trial.meter.without_stop());
  }
  std::ranges::sort(longest);
  const Duration median = longest[kWorlds / 2];
  table.add("(g) a hung adapter, stops of " + std::to_string(clients) + " clients",
            text("%.1f s without a stop", seconds(median)),
            text("%.0f s", seconds(hung_after + 10s)), median <= hung_after + 10s, was_kept);
}

}  // namespace

bool run_bounds() {
  Figures table;
  const unsigned alone = rate_alone();
  for (const unsigned dead : {1U, 6U, 16U}) {
    beside_dead_drives(table, dead, alone);
  }
  shares_of_hosts(table);
  time_until_back(table, 1, true);
  time_until_back(table, 12, true);
  beside_a_scan(table, alone);
  hung_under_stops(table, 1, true);
  hung_under_stops(table, 2, true);
  return table.is_sound();
}

}  // namespace mbgate::judge

// SPDX-License-Identifier: Apache-2.0
// Lines, the drives on them, and how both misbehave.
#include "world/plan.hpp"

#include <algorithm>
#include <string>

#include "world/rights.hpp"

namespace mbgate::world {

using bus::Framing;

namespace {

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) { plan_.seed = seed; }

  Plan make() {
    plan_.default_times = random_.chance(250);
    const unsigned buses = random_.one_of({1U, 1U, 1U, 2U, 2U, 3U});
    for (std::size_t bus = 0; bus < buses; ++bus) {
      add_bus(bus);
    }
    draw_doors(plan_, random_);
    draw_guards(plan_, random_);
    draw_clients(plan_, random_);
    plan_.driver = draw_driver(random_, plan_.seed);
    if (random_.chance(150)) {
      plan_.restarts_every = random_.duration(3s, 60s);
    }
    if (random_.chance(400)) {
      plan_.reloads_every = random_.one_of<Duration>({200ms, 1s, 10s});
      plan_.meanings_change = random_.chance(500);
    }
    draw_rights(plan_);
    set_deadlines(plan_);
    return std::move(plan_);
  }

 private:
  void add_bus(std::size_t index);
  void draw_line(bus::BusSettings& bus, LinePlan& line);
  void draw_server(bus::BusSettings& bus, LinePlan& line);
  void add_station(std::size_t bus, std::uint8_t address);
  Habits draw_habits(const drive::DeviceTiming& timing);
  void be_special(Habits& habits, const drive::DeviceTiming& timing);
  unsigned some() {
    return random_.chance(500) ? 0 : static_cast<unsigned>(random_.below(most_ + 1));
  }
  Duration every(Duration least, Duration most) {
    return most_ > 0 && random_.chance(300) ? random_.duration(least, most) : Duration{0};
  }

  Random random_;
  Plan plan_;
  unsigned most_ = 0;  ///< of chances on the present line
};

void Draw::add_bus(std::size_t index) {
  auto& bus = plan_.settings.buses.emplace_back();
  bus.name = "line-" + std::to_string(index);
  bus.line.device = "/dev/ttyS" + std::to_string(index);
  most_ = random_.one_of({0U, 20U, 60U, 60U, 150U});
  LinePlan line;
  draw_line(bus, line);
  if (bus.line.framing == Framing::tcp) {
    draw_server(bus, line);
  }
  if (!plan_.default_times) {
    bus.listen_first =
        random_.chance(700) ? random_.duration(0ms, 50ms) : std::optional<Duration>();
    bus.turnaround = random_.duration(10ms, 100ms);
    bus.stop_wait = random_.duration(40ms, 100ms);
    bus.reopen_min = 20ms;
    bus.reopen_max = 500ms;
    bus.timing.response_timeout = 50ms;
    bus.hung_after = random_.one_of<Duration>({0s, 2s, 30s});
  }
  bus.settle = random_.chance(200) ? random_.duration(1ms, 20ms) : 0ms;
  bus.queue = random_.one_of<std::size_t>({4, 16, 256, 2048, 2048});
  bus.coalesce = random_.chance(800);
  bus.burst = random_.between(1U, 8U);
  line.noise_every = every(50ms, 5s);
  line.stranger_every = bus.line.framing == Framing::tcp ? 0ms : every(50ms, 5s);
  line.lost_every = every(5s, 120s);
  line.hangs_every = every(20s, 120s);
  line.stalls_every = every(5s, 60s);
  line.tells_unsent = !bus.line.remote;
  plan_.lines.push_back(line);
  if (bus.line.framing == Framing::tcp && random_.chance(400)) {
    add_station(index, 255);
    return;
  }
  unsigned address = 0;
  for (unsigned count = random_.one_of({1U, 2U, 4U, 8U}); count > 0; --count) {
    address += random_.between(1U, 5U);
    add_station(index, low(address));
  }
}

void Draw::draw_line(bus::BusSettings& bus, LinePlan& line) {
  bus.line.baud =
      modbus::Baud{random_.one_of<std::uint32_t>({9600, 19200, 19200, 57600, 115200, 460800})};
  bus.line.framing = random_.one_of(
      {Framing::rtu, Framing::rtu, Framing::rtu, Framing::rtu, Framing::ascii, Framing::tcp});
  if (bus.line.framing == Framing::tcp) {
    return;
  }
  line.adapter = random_.one_of(
      {AdapterKind::uart, AdapterKind::uart, AdapterKind::ticking, AdapterKind::late});
  line.kind =
      line.adapter == AdapterKind::uart
          ? random_.one_of({bus::LineKind::uart, bus::LineKind::uart, bus::LineKind::virtual_line})
          : bus::LineKind::uart;
  if (random_.chance(120)) {
    bus.line.remote = bus::Endpoint{"server-" + bus.name, 4001};
    line.kind = bus::LineKind::virtual_line;
  }
  line.echoes = !bus.line.remote && random_.chance(250);
  if (random_.chance(500)) {
    bus.line.echo = line.echoes;
  }
  bus.line.format.parity = random_.one_of({modbus::Parity::none, modbus::Parity::even});
  if (random_.chance(150)) {
    bus.frame_gap = random_.duration(500us, 5ms);
  }
  if (bus.line.framing == Framing::rtu && random_.chance(200)) {
    bus.frame_slack = random_.duration(15ms, 200ms);
  }
}

void Draw::draw_server(bus::BusSettings& bus, LinePlan& line) {
  bus.line.remote = bus::Endpoint{"far-" + bus.name, 502};
  bus.outstanding = random_.one_of({1U, 1U, 2U, 4U});
  bus.check_unit = random_.chance(300);
  bus.replace_after = random_.one_of({0U, 5U});
  line.other_identifier = some();
  line.other_unit = bus.check_unit ? some() : random_.one_of({0U, some(), 1000U});
  line.wrong_length = some();
  line.half = some();
  line.stray = some();
  line.closes_after = random_.one_of({0U, some(), 300U});
  line.idle_close = every(20ms, 2s);
  constexpr std::uint64_t kIdentifiersChance = 0x4944454EULL;
  if (Random(plan_.seed ^ (kIdentifiersChance + plan_.lines.size())).chance(250)) {
    line.keeps_identifiers = bus.check_transaction = false;
    bus.outstanding = 1;
    bus.check_unit = true;
    line.other_unit = std::min(line.other_unit, most_);
    line.other_identifier = line.stray = 0;
  }
}

void Draw::add_station(std::size_t bus, std::uint8_t address) {
  auto& device = plan_.settings.devices.emplace_back();
  device.name = "device-" + std::to_string(plan_.settings.devices.size());
  device.bus = drive::BusId{static_cast<std::uint32_t>(bus)};
  device.address = address;
  device.has_every_unit = address == 255;
  draw_timing(device.timing, plan_.default_times, random_);
  draw_profile(device, plan_.is_tcp(bus), random_);
  Station station{bus, address, plan_.settings.devices.size() - 1, {}, address == 255};
  const bool has_twin = most_ > 0 && !plan_.is_tcp(bus) && random_.chance(60);
  for (unsigned count = has_twin ? 2 : 1; count > 0; --count) {
    station.drives.push_back(plan_.drives.size());
    DrivePlan& drive = plan_.drives.emplace_back();
    drive.habits = draw_habits(device.timing);
    drive.order = *device.word_order;
    if (has_twin) {
      drive.habits.service = 0ms;
      drive.habits.quick = device.timing.response_timeout / 2;
      drive.habits.dead = false;
    }
  }
  plan_.stations.push_back(std::move(station));
}

Habits Draw::draw_habits(const drive::DeviceTiming& timing) {
  Habits habits;
  habits.quick = random_.one_of<Duration>({1ms, 5ms, timing.response_timeout / 2});
  if (most_ == 0) {
    return habits;
  }
  for (unsigned* rate : {&habits.late, &habits.never, &habits.copies, &habits.damaged, &habits.cut,
                         &habits.pauses, &habits.long_pauses, &habits.misfits, &habits.glitches,
                         &habits.tails, &habits.exceptions, &habits.limits, &habits.deaf}) {
    *rate = some();
  }
  const bool is_ascii = plan_.settings.buses.back().line.framing == bus::Framing::ascii;
  habits.crawls = random_.chance(200) ? random_.between(1U, is_ascii ? 60U : 10U) : 0;
  habits.late *= random_.one_of({1U, 4U});
  habits.cut = habits.cut * 3 / 2;
  habits.very_late = random_.chance(100) ? some() : 0;
  // A copy cannot be told from what a drive still owes, nor from the next answer once it is behind
  // it. Where an adapter keeps requests, any drive may owe.
  const LinePlan& line = plan_.lines.back();
  if (habits.late + habits.very_late > 0 || line.adapter != AdapterKind::uart ||
      line.stalls_every > Duration{0}) {
    habits.copies = 0;
  }
  habits.refuses_stops = random_.chance(300) ? random_.one_of({100U, 500U, 1000U}) : 0;
  be_special(habits, timing);
  return habits;
}

void Draw::be_special(Habits& habits, const drive::DeviceTiming& timing) {
  const Duration timeout = timing.response_timeout;
  const unsigned kind = random_.between(0U, 99U);
  if (kind < 8) {
    habits.service = timeout * random_.between(11, 50) / 10;
    habits.late = habits.very_late = 0;
  } else if (kind < 20) {
    habits.second = random_.one_of({50U, 200U, 1000U});
    habits.second_from = random_.duration(1ms, timeout / 4);
    habits.second_to = habits.second_from + random_.duration(0ms, timeout / 3);
  } else if (kind < 28) {
    habits.dead = true;
  } else if (kind < 40) {
    habits.sleeps_every = random_.duration(1s, 20s);
    habits.sleeps_for = random_.duration(100ms, 10s);
  } else if (kind < 50) {
    habits.sleeps_every = random_.duration(1s, 20s);
    habits.sleeps_for = random_.duration(100ms, timing.quarantine_max * 9 / 10);
    habits.freezes = true;
    habits.late = habits.very_late = 0;  // they would come while it is frozen
    habits.quick = std::min<Duration>(habits.quick, 200ms);
  }
}

}  // namespace

void draw_timing(drive::DeviceTiming& timing, bool is_default, Random& random) {
  if (is_default) {
    timing.response_timeout = random.one_of<Duration>({300ms, 300ms, 1s});
    return;
  }
  timing.response_timeout = random.duration(40ms, 120ms);
  timing.response_wait = random.chance(200) ? random.duration(2ms, 30ms) : 0ms;
  timing.gap = random.chance(200) ? random.duration(1ms, 10ms) : 0ms;
  timing.retries = random.between(0U, 2U);
  timing.retry_writes = random.chance(60);
  timing.stop_retries = random.between(0U, 3U);
  timing.quarantine.reset();
  if (random.chance(400)) {
    timing.quarantine = random.duration(10ms, 400ms);
  }
  timing.quarantine_max = 2s;
  timing.offline_after = random.between(0U, 4U);
  timing.probe_interval = random.duration(600ms, 2s);  // longer than a timeout and its tail
  timing.probe_timeout.reset();
  if (random.chance(300)) {
    timing.probe_timeout = random.duration(25ms, 100ms);
  }
}

// 0.5 s and twice the longest time that an ordinary transaction can hold a bus: a frame of full
// length and a short one, the wait for an answer, and `settle`.
void set_deadlines(Plan& plan) {
  constexpr std::size_t kCharacters = 264;
  constexpr std::size_t kAsciiCharacters = 529;
  for (Door& door : plan.doors) {
    std::vector<std::size_t> buses = door.buses;
    if (door.station) {
      buses = {plan.stations[*door.station].bus};
    }
    Duration longest{0};
    for (const std::size_t at : buses) {
      const bus::BusSettings& bus = plan.bus(at);
      Duration held{0};
      if (bus.line.framing != bus::Framing::tcp) {
        const bool is_ascii = bus.line.framing == bus::Framing::ascii;
        held = WireTimes(bus.line).of(is_ascii ? kAsciiCharacters : kCharacters) + bus.settle;
      }
      for (const drive::Device& device : plan.settings.devices) {
        if (static_cast<std::size_t>(device.bus) == at) {
          longest = std::max(longest,
                             held + device.timing.response_wait + device.timing.response_timeout);
        }
      }
    }
    const auto stated = door.route ? plan.settings.routes[*door.route].deadline : std::nullopt;
    door.write_deadline = stated.value_or(2 * longest + 500ms);
    door.read_deadline = stated.value_or(std::max<Duration>(5s, 2 * longest + 500ms));
  }
}

Plan draw_plan(std::uint64_t seed) { return Draw(seed).make(); }

}  // namespace mbgate::world

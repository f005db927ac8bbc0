// SPDX-License-Identifier: Apache-2.0
#include "soak/plan.hpp"

#include <algorithm>
#include <string>

#include "soak/registers.hpp"

namespace mbgate::soak {
namespace {

using namespace std::chrono_literals;
using bus::Framing;
using drive::WordOrder;

constexpr std::uint8_t kLastAddress = 40;  // those above are nobody's

class Draw {
 public:
  explicit Draw(Random& random) : random_(random) {}

  SoakPlan make() {
    const auto buses = static_cast<std::size_t>(random_.one_of({1, 1, 2, 2, 3, 4}));
    for (std::size_t bus = 0; bus < buses; ++bus) {
      add_bus(bus);
    }
    draw_doors(plan_, random_);
    plan_.beyond = random_.chance(100);
    draw_guards(plan_, random_);
    draw_clients(plan_, random_);
    if (!plan_.silence) {
      plan_.driver = draw_driver(random_);
    }
    return std::move(plan_);
  }

 private:
  void add_bus(std::size_t index);
  void draw_line(bus::BusSettings& bus);
  void draw_rates(const bus::BusSettings& bus);
  void add_device(std::size_t bus, std::uint8_t address);
  drive::DeviceTiming draw_timing();
  drive::Profile draw_profile();
  unsigned some(unsigned most) {
    return random_.chance(300) ? 0 : static_cast<unsigned>(random_.below(most + 1));
  }

  Random& random_;
  SoakPlan plan_;
};

void Draw::draw_line(bus::BusSettings& bus) {
  bus.line.baud = modbus::Baud{random_.one_of<std::uint32_t>(
      {9600, 19200, 38400, 57600, 115200, 115200, 230400, 460800, 921600})};
  bus.line.framing = random_.one_of(
      {Framing::rtu, Framing::rtu, Framing::rtu, Framing::rtu, Framing::ascii, Framing::tcp});
  bus.line.echo = bus.line.framing != Framing::tcp && random_.chance(200);
  if (bus.line.framing == Framing::tcp) {
    bus.line.remote = bus::Endpoint{"far", 502};
    bus.outstanding = random_.between(1, 4);
    bus.check_unit = random_.chance(200);
    bus.replace_after = random_.one_of({0U, 1U, 5U, 5U});
  } else if (random_.chance(150)) {
    bus.frame_gap = random_.duration(500us, 5ms);
  }
  if (bus.line.framing == Framing::rtu && random_.chance(300)) {
    bus.frame_slack = random_.duration(15ms, 200ms);
  }
}

void Draw::add_bus(std::size_t index) {
  auto& bus = plan_.settings.buses.emplace_back();
  bus.name = "line-" + std::to_string(index);
  draw_line(bus);
  bus.listen_first = random_.duration(0ms, 50ms);
  bus.turnaround = random_.duration(10ms, 100ms);
  bus.settle = random_.chance(200) ? random_.duration(1ms, 20ms) : 0ms;
  bus.queue = random_.one_of<std::size_t>({4, 16, 64, 256, 2048});
  bus.coalesce = random_.chance(600);
  bus.merge = random_.chance(250);
  bus.burst = random_.between(1U, 8U);
  // Long enough that a stop on the slowest line leaves and is answered before the next one is due.
  bus.stop_wait = random_.duration(40ms, 100ms);
  // After a probe whose answer dragged on for seconds, 2 % of the time would outlast the quiet
  // phase.
  bus.probe_share = random_.between(10U, 40U);
  bus.reopen_min = 20ms;
  bus.reopen_max = 500ms;
  bus.timing.response_timeout = 50ms;
  draw_rates(bus);
  plan_.adapters.push_back(random_.one_of(
      {AdapterKind::uart, AdapterKind::uart, AdapterKind::ticking, AdapterKind::late}));
  std::uint8_t address = 0;
  for (unsigned count = random_.between(1U, 8U); count > 0; --count) {
    address = static_cast<std::uint8_t>(address + random_.between(1, kLastAddress / 8));
    add_device(index, address);
  }
}

void Draw::draw_rates(const bus::BusSettings& bus) {
  FaultRates rates;
  if (!random_.chance(100)) {
    const unsigned most = random_.one_of({10U, 30U, 60U, 150U});
    for (unsigned* rate :
         {&rates.late, &rates.twice, &rates.never, &rates.garbage, &rates.wrong_unit,
          &rates.wrong_function, &rates.bad_crc, &rates.damaged, &rates.pieces, &rates.glitch,
          &rates.too_long, &rates.babble, &rates.exception, &rates.early, &rates.request_damaged,
          &rates.unknown_identifier}) {
      *rate = some(most);
    }
    rates.late *= random_.one_of({1U, 4U, 8U});  // it is what the quarantine is for
    rates.echo_damaged = bus.line.echo.value_or(false) ? some(most) : 0;
    const auto every = [&](Duration least, Duration longest) {
      return random_.chance(500) ? random_.duration(least, longest) : Duration{0};
    };
    rates.noise_every = every(50ms, 2s);
    rates.foreign_every = every(50ms, 2s);
    rates.lost_every = every(2s, 60s);
    rates.dead_every = every(1s, 20s);
    if (bus.line.framing == Framing::tcp) {
      rates.other_unit = bus.check_unit ? some(most) : random_.one_of({0U, some(most), 1000U});
      rates.closes_after = random_.one_of({0U, some(most), 300U, 1000U});
      rates.closes_at_once = random_.one_of({0U, 0U, some(most), 300U});
      rates.swallows = bus.replace_after > 0 ? random_.one_of({0U, 0U, 100U}) : 0U;
      rates.idle_close = every(20ms, 2s);
    }
  }
  plan_.rates.push_back(rates);
}

drive::DeviceTiming Draw::draw_timing() {
  drive::DeviceTiming timing;
  timing.response_timeout = random_.duration(kShortestTimeout, 120ms);
  timing.response_wait = random_.chance(200) ? random_.duration(2ms, 30ms) : 0ms;
  timing.gap = random_.chance(200) ? random_.duration(1ms, 10ms) : 0ms;
  timing.retries = random_.between(0U, 2U);
  timing.retry_writes = random_.chance(100);
  timing.stop_retries = random_.between(0U, 3U);
  if (random_.chance(600)) {
    timing.quarantine = random_.chance(100) ? 0ms : random_.duration(10ms, 400ms);
  }
  timing.quarantine_max = 2s;
  timing.offline_after = random_.between(0U, 4U);
  timing.probe_interval = random_.duration(100ms, 2s);
  if (random_.chance(300)) {
    timing.probe_timeout = random_.duration(kShortestTimeout, 100ms);
  }
  return timing;
}

drive::Profile Draw::draw_profile() {
  drive::Profile profile;
  for (unsigned at = 0; at < kRegisters; ++at) {
    if (is_in_value(Table::holding_registers, at) && value_begin(at) == at) {
      profile.values.add({Table::holding_registers, static_cast<std::uint16_t>(at),
                          static_cast<std::uint8_t>(value_end(at) - at),
                          is_motion(Table::holding_registers, at)});
    }
  }
  constexpr unsigned kGroup = 4;
  for (unsigned at = kGroupsFrom; at < kGroupsEnd; at += kGroup) {
    profile.groups.push_back({Table::holding_registers, static_cast<std::uint16_t>(at), kGroup});
  }
  profile.write_only.push_back(
      {Table::holding_registers, kWriteOnlyFrom, kMotionFrom - kWriteOnlyFrom});
  profile.communication.push_back({Table::holding_registers, kCommunicationRegister, 1});
  profile.word_order_register = {kOrderRegister, {kBigOrder}, {kLittleOrder}};
  profile.position_opcodes = {kOpcodeRegister, {kPositionOpcode}, kOpcodeRegister + 1};
  profile.stops.push_back({Table::holding_registers, kStopRegister, 0xF000, 0x5000});
  profile.stops.push_back({Table::coils, kStopCoil, 0xFFFF, 0xFF00});
  profile.unanswered.push_back(
      {{Table::holding_registers, kSilentRegister, 0xF000, 0x7000}, random_.duration(10ms, 200ms)});
  profile.slow.push_back(
      {{Table::holding_registers, kSlowFrom, 4}, random_.duration(100ms, 400ms)});
  if (random_.chance(500)) {
    const auto most = random_.between<std::uint16_t>(4, 64);
    profile.limits.read = {2000, 2000, most, most};
    profile.limits.write_coils = static_cast<std::uint16_t>(16U * random_.between(1U, 6U));
    profile.limits.write_registers = random_.between<std::uint16_t>(4, 8);
  }
  if (random_.chance(300)) {
    profile.functions.reset(random_.one_of<std::size_t>(
        {0x07, 0x08, 0x0B, 0x0C, 0x11, 0x14, 0x15, 0x16, 0x17, 0x18, 0x2B, kOwnFunction}));
  }
  profile.input_as_holding = random_.chance(150);
  return profile;
}

// It takes what the manual lists, and so many registers at once.
void be_autonics(drive::Broadcast& broadcast) {
  broadcast.form = drive::BroadcastForm::autonics;
  broadcast.most_registers = kMostOfAutonics;
  broadcast.allowed = {{Table::holding_registers, kStopRegister, 3},
                       {Table::holding_registers, kBroadcastRun, kMostOfBroadcastRun},
                       {Table::coils, kStopCoil, kCoils - kStopCoil}};
}

void Draw::add_device(std::size_t bus, std::uint8_t address) {
  auto& device = plan_.settings.devices.emplace_back();
  device.name = "device-" + std::to_string(plan_.settings.devices.size());
  device.bus = drive::BusId{static_cast<std::uint32_t>(bus)};
  device.address = address;
  device.timing = draw_timing();
  device.profile = draw_profile();
  device.word_order = random_.one_of({WordOrder::big, WordOrder::little});
  device.split_writes = random_.chance(500);
  device.stop_cancels = random_.chance(800);
  device.cache = random_.chance(250) ? random_.duration(5ms, 200ms) : 0ms;
  if (random_.chance(300)) {
    device.write_function = random_.one_of<std::uint8_t>({6, 16});
  }
  device.split_values = random_.chance(500);
  device.allow_reconfigure = random_.chance(500);
  if (random_.chance(500)) {
    device.opcode_order = random_.one_of({WordOrder::big, WordOrder::little});
  }
  device.verify_word_order = random_.chance(200);
  const bool lies = device.verify_word_order && random_.chance(200);
  plan_.own_orders.push_back(lies == (*device.word_order == WordOrder::big) ? WordOrder::little
                                                                            : WordOrder::big);
  if (plan_.settings.buses[bus].line.framing != Framing::tcp && random_.chance(150)) {
    be_autonics(device.profile.broadcast);
  }
}

}  // namespace

SoakPlan draw_plan(Random& random, std::uint64_t seed) {
  SoakPlan plan = Draw(random).make();
  draw_lines(plan, seed);
  draw_limits(plan, seed);
  draw_forms(plan, seed);
  draw_orders(plan, seed);
  draw_odds(plan, seed);
  draw_late(plan, seed);
  draw_access(plan, seed);
  draw_close_access(plan, seed);
  draw_tables(plan, seed);
  draw_reads(plan, seed);
  if (!plan.silence) {
    draw_stops(plan.driver, seed);
  }
  draw_broadcasts(plan, seed);
  draw_rare_faults(plan, seed);
  draw_theme(plan, seed);
  draw_windows(plan, seed);
  draw_own_routes(plan, seed);
  draw_roles_alone(plan, seed);
  draw_client_rates(plan, seed);
  draw_ways(plan, seed);
  // They follow from all that was drawn for their lines.
  for (Door& door : plan.doors) {
    set_deadlines(plan, door);
  }
  return plan;
}

}  // namespace mbgate::soak

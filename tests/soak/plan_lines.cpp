// SPDX-License-Identifier: Apache-2.0
// What is behind each serial line, and what the settings say of it: does it hear itself, does it
// keep the pace of the wire. With a chance of its own, so that plants and clients stay those of the
// seed.
#include <algorithm>

#include "soak/plan.hpp"
#include "soak/registers.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;
using bus::LineKind;

namespace {

constexpr std::uint64_t kLinesOwnChance = 0x4543484FULL;  // apart from the plant's
constexpr std::uint64_t kWiresChance = 0x57495245ULL;

unsigned up_to(Random& random, unsigned most) {
  return random.chance(300) ? 0 : static_cast<unsigned>(random.below(most + 1));
}

// Echoes that are damaged, lost or cut; what is answered before it was sent; and babblers.
void draw_faults(SoakPlan& plan, std::size_t bus, Random& random) {
  FaultRates& rates = plan.rates[bus];
  const unsigned most = random.one_of({0U, 10U, 30U, 60U});
  rates.echo_damaged = std::max(rates.echo_damaged, up_to(random, most));
  rates.echo_lost = up_to(random, most);
  rates.echo_cut = up_to(random, most);
  rates.prompt = plan.kinds[bus] == LineKind::uart ? random.one_of({0U, 0U, 5U, 20U})
                                                   : random.one_of({0U, 100U, 400U});
  rates.babbles_every = random.chance(150) ? random.duration(5s, 40s) : 0ms;
}

}  // namespace

bool is_paced(const SoakPlan& plan, std::size_t bus) {
  return plan.settings.buses[bus].line.paced.value_or(plan.kinds[bus] == LineKind::uart);
}

bool is_for_all(const SoakPlan& plan, std::size_t bus, std::uint8_t address) {
  return address == 0 ||
         (address == kAutonicsAddress &&
          std::ranges::any_of(plan.settings.devices, [&](const drive::Device& device) {
            return static_cast<std::size_t>(device.bus) == bus &&
                   device.profile.broadcast.form == drive::BroadcastForm::autonics;
          }));
}

// Settings that deny an echo are wrong where there is one: where the line is paced it comes before
// the request has left, as long as nobody keeps it back.
void draw_line_kind(SoakPlan& plan, std::size_t bus, Random& random) {
  bus::LineSettings& line = plan.settings.buses[bus].line;
  const bool echoes = line.echo.value_or(false) || random.chance(250);
  plan.echoes[bus] = echoes;
  plan.kinds[bus] = random.one_of(
      {LineKind::uart, LineKind::uart, LineKind::uart, LineKind::adapter, LineKind::virtual_line});
  line.paced.reset();
  if (random.chance(300)) {
    line.paced = random.chance(500);
  }
  line.echo.reset();
  if (random.chance(400)) {
    const bool may_deny = plan.adapters[bus] == AdapterKind::uart && is_paced(plan, bus);
    line.echo = echoes && !(may_deny && random.chance(400));
  }
}

// Slow lines, other characters, device servers in the network.
void draw_wire(SoakPlan& plan, std::size_t bus, Random& random) {
  bus::BusSettings& settings = plan.settings.buses[bus];
  bus::LineSettings& line = settings.line;
  // In ASCII a long answer takes seconds then.
  if (random.chance(line.framing == bus::Framing::ascii ? 350 : 120)) {
    line.baud = modbus::Baud{random.one_of<std::uint32_t>({1200, 2400, 4800})};
    settings.stop_wait = random.duration(300ms, 900ms);  // a stop has left by then
  }
  if (random.chance(500)) {
    line.format.parity =
        random.one_of({modbus::Parity::none, modbus::Parity::even, modbus::Parity::odd});
    line.format.stop_bits = random.one_of<std::uint8_t>({1, 2});
    const bool is_short = line.framing == bus::Framing::ascii && random.chance(700);
    line.format.data_bits = is_short ? 7 : 8;
  }
  if (random.chance(120)) {
    line.remote = bus::Endpoint{"server", 4001};
    plan.kinds[bus] = LineKind::virtual_line;
    plan.echoes[bus] = false;
    line.echo.reset();
    line.paced.reset();
  }
}

void draw_lines(SoakPlan& plan, std::uint64_t seed) {
  Random random(seed ^ kLinesOwnChance);
  Random wires(seed ^ kWiresChance);
  const std::size_t buses = plan.settings.buses.size();
  plan.seed = seed;
  plan.echoes.resize(buses);
  plan.kinds.resize(buses, LineKind::virtual_line);
  for (std::size_t bus = 0; bus < buses; ++bus) {
    bus::BusSettings& settings = plan.settings.buses[bus];
    if (settings.line.framing == bus::Framing::tcp) {
      continue;
    }
    settings.hung_after = 0ms;  // but where draw_forms() says otherwise
    draw_line_kind(plan, bus, random);
    draw_wire(plan, bus, wires);
    const FaultRates& rates = plan.rates[bus];
    const bool is_calm = rates.noise_every == 0ms && rates.foreign_every == 0ms &&
                         rates.lost_every == 0ms && random.chance(500);
    if (!is_calm) {
      draw_faults(plan, bus, random);
    }
  }
}

}  // namespace mbgate::soak

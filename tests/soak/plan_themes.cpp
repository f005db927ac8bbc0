// SPDX-License-Identifier: Apache-2.0
// Themes: some plans are arranged so that what seldom happens happens often. Their lines are quiet,
// because noise, other settings and late processes excuse what must be seen here. With a chance of
// their own, so that all other plants and clients stay those of the seed.
#include "soak/plan_themes.hpp"

#include <algorithm>

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr std::uint64_t kThemesChance = 0x5448454D45ULL;  // apart from the plant's
constexpr std::uint64_t kCalmChance = 0x43414C4DULL;
constexpr std::uint64_t kMoreChance = 0x4D4F5245ULL;
constexpr std::uint64_t kWaysChance = 0x5741595354ULL;
constexpr std::size_t kLeastDrives = 4;

}  // namespace

ThemeDraw::ThemeDraw(SoakPlan& plan, std::uint64_t seed)
    : plan_(plan),
      random_(seed ^ kThemesChance),
      calm_(seed ^ kCalmChance),
      more_(seed ^ kMoreChance),
      ways_(seed ^ kWaysChance) {}

void ThemeDraw::arrange() {
  // Where silence of the clients is judged, everything else is kept out already.
  const unsigned which = random_.between(0U, 999U);
  const auto lines = fitting_lines();
  if (lines.empty() || plan_.silence) {
    return;
  }
  pick(which);
  if (plan_.theme == Theme::none) {
    return;
  }
  let_everybody_in();
  for (const std::size_t bus : lines) {
    calm(bus);
    arrange(bus);
    add_more(bus);
  }
}

void ThemeDraw::pick(unsigned which) {
  plan_.theme = which < 140   ? Theme::dead_drives
                : which < 180 ? Theme::busy_line
                : which < 260 ? Theme::shared_reads
                : which < 360 ? Theme::late_drives
                : which < 480 ? Theme::busy_line
                : which < 600 ? Theme::shared_reads
                : which < 720 ? Theme::stops
                : which < 920 ? Theme::none
                              : Theme::omissions;
  part_ = which < 360 ? Part::usual : which < 480 ? Part::writers : Part::deserters;
  if (plan_.theme == Theme::none && more_.chance(600)) {
    plan_.theme = Theme::stops;
    part_ = more_.one_of({Part::let_go, Part::alike, Part::between, Part::several});
  }
  if (ways_.chance(150)) {
    plan_.theme = ways_.one_of({Theme::slow_drives, Theme::second_answers});
  }
}

void ThemeDraw::arrange(std::size_t bus) {
  switch (plan_.theme) {
    case Theme::dead_drives: return let_die(bus);
    case Theme::busy_line: return part_ == Part::writers ? write_much(bus) : crowd(bus);
    case Theme::shared_reads: return part_ == Part::deserters ? desert(bus) : share(bus);
    case Theme::late_drives: return be_late(bus);
    case Theme::omissions: return omit(bus);
    case Theme::slow_drives: return be_slow(bus);
    case Theme::second_answers: return answer_twice(bus);
    case Theme::stops: break;
    case Theme::none: return;
  }
  switch (part_) {
    case Part::let_go: return stop_behind_writes(bus);
    case Part::alike: return stop_alike(bus);
    case Part::between: return stop_between(bus);
    case Part::several: return stop_several(bus);
    default: return stop_much(bus);
  }
}

std::vector<std::size_t> ThemeDraw::devices_on(std::size_t bus) const {
  std::vector<std::size_t> found;
  for (std::size_t index = 0; index < plan_.settings.devices.size(); ++index) {
    if (static_cast<std::size_t>(plan_.settings.devices[index].bus) == bus) {
      found.push_back(index);
    }
  }
  return found;
}

// One, or two.
std::vector<std::size_t> ThemeDraw::fitting_lines() {
  std::vector<std::size_t> lines;
  for (std::size_t bus = 0; bus < plan_.settings.buses.size(); ++bus) {
    if (plan_.settings.buses[bus].line.framing == bus::Framing::rtu &&
        devices_on(bus).size() >= kLeastDrives) {
      lines.push_back(bus);
    }
  }
  lines.resize(std::min<std::size_t>(lines.size(), random_.one_of({1U, 1U, 2U})));
  return lines;
}

// Nobody is refused, closed or written for, and the process is on time in half of the plants.
void ThemeDraw::let_everybody_in() {
  gateway::Settings& settings = plan_.settings;
  for (gateway::ListenerSettings& listener : settings.listeners) {
    listener.max_connections = listener.max_connections_per_address = 1000;
    listener.idle_timeout = 0ms;
    listener.pipeline = 16;
    listener.ordered = false;
    listener.read_only = {};
    listener.tls.reset();
  }
  std::ranges::fill(plan_.readers, std::vector<unsigned>{});
  std::ranges::fill(settings.guards, gateway::DeviceGuard{});
  std::ranges::fill(plan_.writers, std::vector<unsigned>{});
  std::ranges::fill(plan_.failsafe, std::vector<std::vector<std::uint8_t>>{});
  settings.rules.clear();
  plan_.rules.clear();
  plan_.sleepers.assign(settings.devices.size(), false);
  plan_.clients.clear();
  plan_.beyond = false;
  if (random_.chance(500)) {
    plan_.driver = {};
  }
}

// It hears nothing but answers, and these as they come.
void ThemeDraw::calm(std::size_t bus) {
  bus::BusSettings& settings = plan_.settings.buses[bus];
  settings.line = {};
  settings.line.baud = modbus::Baud{random_.one_of<std::uint32_t>({19200, 57600, 115200})};
  settings.frame_gap.reset();
  settings.frame_slack.reset();
  settings.hung_after = 0ms;
  settings.queue = 256;
  plan_.kinds[bus] = random_.one_of({bus::LineKind::uart, bus::LineKind::virtual_line});
  plan_.echoes[bus] = false;
  settings.line.echo = random_.chance(500) ? std::optional(false) : std::nullopt;
  plan_.adapters[bus] = AdapterKind::uart;
  plan_.rates[bus] = {};
  for (const std::size_t index : devices_on(bus)) {
    drive::DeviceTiming& timing = plan_.settings.devices[index].timing;
    timing.response_wait = 0ms;
    timing.gap = random_.chance(150) ? random_.duration(1ms, 10ms) : 0ms;
    timing.retry_writes = false;
  }
}

// The probes' times over their whole ranges, as far as the quiet phase lasts as long.
void ThemeDraw::set_times(drive::DeviceTiming& timing) {
  timing.response_timeout = random_.duration(kShortestTimeout, 120ms);
  timing.quarantine.reset();
  if (random_.chance(300)) {
    timing.quarantine = random_.duration(0ms, 100ms);
  }
  timing.quarantine_max = random_.duration(250ms, 600ms);  // longer than any boots
  timing.offline_after = random_.between(1U, 2U);
  timing.probe_interval = random_.one_of(
      {random_.duration(1ms, 50ms), random_.duration(50ms, 500ms), random_.duration(500ms, 8s)});
  timing.probe_timeout.reset();
  if (random_.chance(700)) {
    timing.probe_timeout = random_.duration(kShortestTimeout, 150ms);
  }
}

// Of at least four drives one or two sleep. Some clients stop these in every scan, others read them
// or the living ones, in some plants with rests that leave the line to the probes.
void ThemeDraw::let_die(std::size_t bus) {
  bus::BusSettings& settings = plan_.settings.buses[bus];
  settings.probe_share = random_.one_of({1U, 2U, 5U, random_.between(1U, 100U)});
  settings.timing.probe_interval = random_.duration(50ms, 2s);
  settings.stop_wait = random_.duration(25ms, 100ms);
  settings.coalesce = random_.chance(300);
  settings.merge = settings.merge && random_.chance(300);
  plan_.rates[bus].sleeps = random_.one_of<Duration>({500ms, 3s, 20s});
  std::vector<std::size_t> living = devices_on(bus);
  std::vector<std::size_t> dead;
  for (unsigned count = random_.between(1U, 2U); count > 0; --count) {
    const auto picked = living.begin() + static_cast<std::ptrdiff_t>(random_.below(living.size()));
    dead.push_back(*picked);
    plan_.sleepers[*picked] = true;
    living.erase(picked);
  }
  for (const std::size_t index : devices_on(bus)) {
    drive::Device& device = plan_.settings.devices[index];
    set_times(device.timing);
    if (random_.chance(400)) {
      device.cache = random_.duration(50ms, 1s);
    }
  }
  const auto rest = random_.one_of<Duration>({50ms, 50ms, 300ms, 2s});
  for (unsigned count = random_.between(1U, 3U); count > 0; --count) {
    Manners polls = client(bus, living);
    polls.pause = rest;
    polls.writes = random_.one_of({0U, 100U});
    plan_.clients.push_back(polls);
  }
  for (unsigned count = random_.between(1U, 2U); count > 0; --count) {
    Manners asks = client(bus, dead);
    asks.writes = random_.one_of({0U, 300U});
    asks.same_reads = random_.one_of<std::uint16_t>({0, 900});
    asks.watches = 100;
    plan_.clients.push_back(asks);
  }
  for (unsigned count = random_.between(0U, 2U); count > 0; --count) {
    Manners stops = client(bus, dead);
    stops.stops = random_.one_of({300U, 900U});
    plan_.clients.push_back(stops);
  }
  if (random_.chance(250)) {  // nobody asks for those that are there
    std::erase_if(plan_.clients, [&](const Manners& it) { return it.devices == living; });
  }
}

// They are asked all of the time, but slowly: what was learned of one minute is needed in the next.
void ThemeDraw::be_late(std::size_t bus) {
  FaultRates& rates = plan_.rates[bus];
  rates.late = random_.one_of({200U, 400U});
  rates.late_pieces = random_.one_of({0U, 300U});
  rates.are_quick = random_.chance(500);
  rates.never = random_.one_of({0U, 100U});
  auto devices = devices_on(bus);
  devices.resize(random_.between(1U, 2U));
  for (const std::size_t index : devices) {
    drive::DeviceTiming& timing = plan_.settings.devices[index].timing;
    timing.quarantine = random_.duration(0ms, 100ms);
    timing.quarantine_max = random_.duration(300ms, 600ms);
    timing.offline_after = 0;
  }
  if (calm_.chance(800)) {  // what they were is forgotten by then, and they are late again
    const FaultRates own = rates;
    std::ranges::fill(plan_.rates, FaultRates{});
    rates = own;
    plan_.calm.from = Instant{} + calm_.duration(90s, 150s);
    plan_.calm.until = plan_.calm.from + calm_.duration(61min, 120min);
  }
  for (unsigned count = random_.between(2U, 3U); count > 0; --count) {
    Manners asks = client(bus, devices);
    asks.burst = asks.outstanding = 2;
    asks.least_pause = 500ms;
    asks.pause = random_.one_of<Duration>({4s, 8s});
    asks.writes = random_.one_of({0U, 200U});
    plan_.clients.push_back(asks);
  }
}

// From a host of its own, through the bus's own listener.
Manners ThemeDraw::client(std::size_t bus, std::vector<std::size_t> devices) {
  Manners manners;
  const auto& listeners = plan_.settings.listeners;
  const auto straight = std::ranges::find_if(listeners, [&](const auto& listener) {
    return listener.bus && static_cast<std::size_t>(*listener.bus) == bus;
  });
  manners.listener = static_cast<std::size_t>(straight - listeners.begin());
  manners.host = hosts_++ % kMostHosts;
  manners.devices = std::move(devices);
  manners.burst = random_.one_of({1U, 2U, 4U});
  manners.outstanding = random_.one_of({1U, 2U, 4U});
  manners.pause = random_.one_of<Duration>({10ms, 50ms, 200ms});
  manners.least_pause = 1ms;
  return manners;
}

void draw_theme(SoakPlan& plan, std::uint64_t seed) {
  draw_restarts(plan, seed);
  ThemeDraw(plan, seed).arrange();
}

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
// Lines on which requests wait for each other: for their turns, or to be sent as one.
#include "soak/plan_themes.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

// Nothing but the turn decides who goes first.
void ThemeDraw::wait_for_turns(std::size_t bus) {
  bus::BusSettings& settings = plan_.settings.buses[bus];
  settings.coalesce = settings.merge = false;
  settings.settle = 0ms;
  draw_weights(plan_, random_);
  for (const std::size_t index : devices_on(bus)) {
    plan_.settings.devices[index].cache = 0ms;
    plan_.settings.devices[index].timing.gap = 0ms;
  }
}

// All want to read all of the time.
void ThemeDraw::crowd(std::size_t bus) {
  wait_for_turns(bus);
  const auto devices = devices_on(bus);
  if (random_.chance(400)) {
    plan_.settings.devices[devices.front()].timing.gap = random_.duration(5ms, 20ms);
  }
  for (unsigned count = random_.between(3U, 6U); count > 0; --count) {
    Manners reads = client(bus, devices);
    reads.burst = reads.outstanding = random_.between(2U, 8U);
    reads.pause = random_.one_of<Duration>({1ms, 5ms, 20ms});
    plan_.clients.push_back(reads);
  }
}

// Some write all of the time, to drives of their own or to the same ones, and others want to read.
void ThemeDraw::write_much(std::size_t bus) {
  wait_for_turns(bus);
  plan_.settings.buses[bus].burst = random_.between(1U, 3U);
  const auto devices = devices_on(bus);
  const bool are_apart = random_.chance(700);
  const auto fill = [&](unsigned writes, const std::vector<std::size_t>& asked) {
    Manners manners = client(bus, asked);
    manners.writes = writes;
    manners.burst = manners.outstanding = random_.between(2U, 8U);
    manners.pause = random_.one_of<Duration>({1ms, 5ms, 20ms});
    plan_.clients.push_back(manners);
  };
  for (unsigned count = random_.between(2U, 4U); count > 0; --count) {
    fill(1000, are_apart ? std::vector{devices[count % devices.size()]} : devices);
  }
  for (unsigned count = random_.between(1U, 3U); count > 0; --count) {
    fill(random_.one_of({0U, 0U, 100U}), devices);
  }
}

// Few drives are asked, all for the same, so that reads wait before and behind writes and
// broadcasts; what is kept is kept for longer than the line is away.
void ThemeDraw::share(std::size_t bus) {
  bus::BusSettings& settings = plan_.settings.buses[bus];
  settings.coalesce = true;
  settings.merge = random_.chance(200);
  settings.burst = random_.between(1U, 2U);
  settings.listen_first = random_.duration(0ms, 20ms);
  auto devices = devices_on(bus);
  devices.resize(random_.between(1U, 2U));
  plan_.rates[bus].exception = random_.one_of({0U, 0U, 100U});
  if (random_.chance(500)) {
    plan_.rates[bus].lost_every = random_.duration(500ms, 2s);
    for (const std::size_t index : devices) {
      plan_.settings.devices[index].cache = random_.duration(500ms, 3s);
    }
  }
  for (unsigned count = random_.between(4U, 8U); count > 0; --count) {
    Manners asks = client(bus, devices);
    asks.same_reads = 900;
    asks.pause = random_.one_of<Duration>({5ms, 20ms, 100ms});
    asks.writes = random_.one_of({0U, 0U, 50U});
    asks.broadcasts = random_.one_of({0U, 0U, 200U});
    plan_.clients.push_back(asks);
  }
}

// Whoever waits for a drive with a gap waits for longer than others, and so do stops that let
// writes to it go first. Answers come slowly, some late, some not at all.
void ThemeDraw::stop_much(std::size_t bus) {
  bus::BusSettings& settings = plan_.settings.buses[bus];
  settings.stop_wait = random_.duration(25ms, 60ms);
  settings.coalesce = settings.merge = random_.chance(200);
  plan_.rates[bus].never = random_.one_of({0U, 50U, 200U});
  plan_.rates[bus].late = random_.one_of({0U, 0U, 300U});
  auto devices = devices_on(bus);
  devices.resize(random_.between(1U, 3U));
  const bool have_gaps = random_.chance(700);
  for (const std::size_t index : devices) {
    drive::Device& device = plan_.settings.devices[index];
    set_times(device.timing);
    device.timing.response_timeout = random_.duration(60ms, 120ms);
    device.timing.gap = have_gaps ? random_.duration(10ms, 40ms) : 0ms;
    device.timing.offline_after = random_.one_of({0U, 3U, 20U});
    device.stop_cancels = random_.chance(300);
  }
  if (random_.chance(500)) {
    plan_.rates[bus].sleeps = 3s;
    plan_.sleepers[devices.front()] = true;
  }
  const auto add = [&](unsigned writes, unsigned stops) {
    Manners manners = client(bus, devices);
    manners.writes = writes;
    manners.stops = stops;
    manners.burst = manners.outstanding = random_.between(1U, 6U);
    plan_.clients.push_back(manners);
  };
  for (unsigned count = random_.between(1U, 3U); count > 0; --count) {
    add(900, random_.one_of({0U, 50U}));
  }
  for (unsigned count = random_.between(1U, 2U); count > 0; --count) {
    add(0, random_.one_of({100U, 1000U}));
    plan_.clients.back().burst = plan_.clients.back().outstanding = 1;
    plan_.clients.back().pause = 400ms;
  }
  add(0, 0);
}

// They ask for the same at the same time and are often not answered. Some wait for a little while
// only, some until their route's deadline.
void ThemeDraw::desert(std::size_t bus) {
  bus::BusSettings& settings = plan_.settings.buses[bus];
  settings.coalesce = true;
  settings.merge = false;
  plan_.rates[bus].never = random_.one_of({200U, 500U, 800U});
  auto devices = devices_on(bus);
  devices.resize(random_.between(1U, 3U));
  for (const std::size_t index : devices) {
    drive::DeviceTiming& timing = plan_.settings.devices[index].timing;
    timing.retries = random_.between(1U, 3U);
    timing.offline_after = random_.one_of({0U, 20U});
    timing.quarantine = random_.duration(0ms, 30ms);
    timing.quarantine_max = random_.duration(250ms, 600ms);  // longer than any boots
    plan_.settings.devices[index].cache = 0ms;
  }
  const auto step = random_.one_of<Duration>({50ms, 100ms, 300ms});
  for (unsigned count = random_.between(3U, 8U); count > 0; --count) {
    Manners asks = client(bus, devices);
    asks.listener = random_.chance(300) ? 0 : asks.listener;  // by its routes
    asks.same_reads = 950;
    asks.writes = random_.one_of({0U, 0U, 50U});
    asks.in_step = step;
    asks.burst = random_.between(1U, 2U);
    asks.patience = random_.chance(500) ? random_.duration(5ms, 400ms) : 0ms;
    plan_.clients.push_back(asks);
  }
}

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
// Stops that meet what they seldom meet: several writes that go first, identical stops after their
// last try, stops of other drives, reads that are repeated.
#include "soak/plan_themes.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

void ThemeDraw::set_slow(std::size_t device) {
  drive::DeviceTiming& timing = plan_.settings.devices[device].timing;
  set_times(timing);
  timing.response_timeout = random_.duration(60ms, 120ms);
  timing.offline_after = 0;
}

// What a stop lets go first are several writes of a few clients, also behind reads of their own.
void ThemeDraw::stop_behind_writes(std::size_t bus) {
  bus::BusSettings& settings = plan_.settings.buses[bus];
  settings.stop_wait = random_.duration(30ms, 60ms);
  settings.coalesce = settings.merge = false;
  settings.settle = 0ms;
  plan_.rates[bus].never = random_.one_of({0U, 0U, 30U});
  auto devices = devices_on(bus);
  devices.resize(random_.between(1U, 2U));
  for (const std::size_t index : devices) {
    drive::Device& device = plan_.settings.devices[index];
    set_slow(index);
    device.timing.gap = random_.duration(5ms, 25ms);
    device.stop_cancels = false;
    device.cache = 0ms;
  }
  for (unsigned count = random_.between(1U, 3U); count > 0; --count) {
    Manners writes = client(bus, devices);
    writes.writes = random_.one_of({500U, 900U});
    writes.burst = writes.outstanding = random_.between(3U, 6U);
    plan_.clients.push_back(writes);
  }
  Manners stops = client(bus, devices);
  stops.stops = 1000;
  stops.burst = stops.outstanding = 1;
  stops.pause = 300ms;
  plan_.clients.push_back(stops);
}

// Who joins one that was tried already is still to be sent when that is given up, because the line
// is never silent.
void ThemeDraw::stop_alike(std::size_t bus) {
  plan_.rates[bus].babbles_every = random_.one_of<Duration>({500ms, 2s});
  plan_.rates[bus].never = random_.one_of({300U, 600U, 900U});
  plan_.settings.buses[bus].stop_wait = random_.duration(25ms, 100ms);
  auto devices = devices_on(bus);
  devices.resize(random_.between(1U, 2U));
  for (const std::size_t index : devices) {
    set_slow(index);
    plan_.settings.devices[index].timing.stop_retries = random_.between(1U, 3U);
  }
  for (unsigned count = random_.between(2U, 4U); count > 0; --count) {
    Manners stops = client(bus, devices);
    stops.stops = 1000;
    stops.same_stops = true;
    stops.burst = stops.outstanding = 1;
    plan_.clients.push_back(stops);
  }
  plan_.clients.push_back(client(bus, devices));
}

// One drive sleeps and is asked again and again. Others, which are stopped, wait for their turn.
void ThemeDraw::stop_between(std::size_t bus) {
  bus::BusSettings& settings = plan_.settings.buses[bus];
  settings.coalesce = settings.merge = false;
  settings.settle = 0ms;
  plan_.rates[bus].sleeps = 20s;
  auto devices = devices_on(bus);
  devices.resize(3);
  for (const std::size_t index : devices) {
    set_slow(index);
    plan_.settings.devices[index].timing.gap = 0ms;
    plan_.settings.devices[index].timing.retries = 3;
    plan_.settings.devices[index].cache = 0ms;
  }
  plan_.sleepers[devices.front()] = true;
  Manners asks = client(bus, {devices.front()});
  asks.pause = 10ms;
  plan_.clients.push_back(asks);
  const std::vector<std::size_t> living(devices.begin() + 1, devices.end());
  for (unsigned count = random_.between(2U, 4U); count > 0; --count) {
    Manners polls = client(bus, living);
    polls.burst = polls.outstanding = random_.between(2U, 4U);
    polls.pause = 10ms;
    plan_.clients.push_back(polls);
  }
  Manners stops = client(bus, living);
  stops.stops = 1000;
  stops.burst = stops.outstanding = 1;
  stops.pause = random_.one_of<Duration>({50ms, 200ms});
  plan_.clients.push_back(stops);
}

// Through routes, so that writes are split into runs.
void ThemeDraw::stop_several(std::size_t bus) {
  plan_.settings.buses[bus].stop_wait = random_.duration(40ms, 100ms);
  auto devices = devices_on(bus);
  devices.resize(3);
  for (const std::size_t index : devices) {
    drive::Device& device = plan_.settings.devices[index];
    set_slow(index);
    device.write_function = 6;
    device.split_writes = device.split_values = true;
    device.stop_cancels = true;
  }
  for (const std::size_t index : devices) {
    Manners writes = client(bus, {index});
    writes.listener = 0;
    writes.writes = 1000;
    writes.burst = writes.outstanding = 2;
    plan_.clients.push_back(writes);
  }
  const auto step = random_.one_of<Duration>({100ms, 200ms});
  for (const std::size_t index : devices) {
    Manners stops = client(bus, {index});
    stops.stops = 1000;
    stops.burst = stops.outstanding = 1;
    stops.in_step = step;
    plan_.clients.push_back(stops);
  }
}

// Who waits for the next try of a read speaks to all; and those that live are stopped while others
// are dead.
void ThemeDraw::add_more(std::size_t bus) {
  if (part_ == Part::deserters && plan_.theme == Theme::shared_reads && more_.chance(600)) {
    for (Manners& manners : plan_.clients) {
      manners.broadcasts = 150;
    }
  }
  if (plan_.theme == Theme::dead_drives && more_.chance(600)) {
    std::vector<std::size_t> living = devices_on(bus);
    std::erase_if(living, [&](std::size_t index) { return plan_.sleepers[index]; });
    Manners stops = client(bus, living);
    stops.stops = 1000;
    stops.burst = stops.outstanding = 1;
    stops.pause = 100ms;
    plan_.clients.push_back(stops);
  }
}

}  // namespace mbgate::soak

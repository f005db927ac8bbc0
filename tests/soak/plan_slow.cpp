// SPDX-License-Identifier: Apache-2.0
// Quiet lines with drives that leave out an answer now and then; or with one that works in order
// and takes longer than its response timeout, or that answers twice: nothing else happens there, so
// that each wrong answer is one of these.
#include "soak/plan_themes.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr int kTenths = 10;
constexpr int kLeastTenths = 11;  // of a response timeout
constexpr int kMostTenths = 50;
constexpr int kMostSureTenths = 25;  // with retries nothing slips up to then

}  // namespace

// All that is asked of it waits in the drive. Default times but for the timeout.
void ThemeDraw::be_slow(std::size_t bus) {
  bus::BusSettings& settings = plan_.settings.buses[bus];
  settings.merge = false;
  settings.coalesce = ways_.chance(300);
  const std::size_t index = devices_on(bus).front();
  drive::DeviceTiming& timing = ask_plainly(index);
  const int tenths = ways_.between(kLeastTenths, kMostTenths);
  Ways& ways = plan_.ways[index];
  ways.service = timing.response_timeout * tenths / kTenths;
  const bool is_sure = timing.retries > 0 && tenths <= kMostSureTenths;
  ways.most_wrong = is_sure && plan_.restarts_every == 0ms ? 0 : kMostAtAStart;
  ask_all_the_time(bus, index);
}

// Within the response timeout.
void ThemeDraw::answer_twice(std::size_t bus) {
  const std::size_t index = devices_on(bus).front();
  const drive::DeviceTiming& timing = ask_plainly(index);
  FaultRates& rates = plan_.rates[bus];
  rates.are_quick = ways_.chance(700);
  rates.request_damaged = ways_.one_of({0U, 0U, 50U});
  rates.never = ways_.one_of({0U, 0U, 50U});
  Ways& ways = plan_.ways[index];
  ways.second = ways_.one_of({50U, 200U, 500U, 1000U, 1000U});
  ways.second_from = ways_.duration(1ms, timing.response_timeout / 2);
  ways.second_to = ways.second_from + ways_.duration(0ms, 10ms);
  ask_all_the_time(bus, index);
}

// Somebody else always waits, for the same drive too, and wants something else.
void ThemeDraw::omit(std::size_t bus) {
  bus::BusSettings& settings = plan_.settings.buses[bus];
  settings.coalesce = settings.merge = false;
  settings.settle = 0ms;
  plan_.rates[bus].are_quick = true;
  plan_.rates[bus].never = random_.one_of({50U, 150U});
  auto devices = devices_on(bus);
  devices.resize(random_.between(1U, 3U));
  for (const std::size_t index : devices) {
    drive::Device& device = plan_.settings.devices[index];
    device.cache = 0ms;
    device.timing.response_timeout = random_.duration(kShortestTimeout, 60ms);
    device.timing.quarantine = random_.duration(50ms, 400ms);
    device.timing.offline_after = 0;
  }
  for (unsigned count = random_.between(2U, 4U); count > 0; --count) {
    Manners asks = client(bus, devices);
    asks.outstanding = random_.between(2U, 4U);
    asks.writes = random_.one_of({100U, 300U, 600U});
    plan_.clients.push_back(asks);
  }
}

drive::DeviceTiming& ThemeDraw::ask_plainly(std::size_t device) {
  drive::Device& it = plan_.settings.devices[device];
  it.cache = 0ms;
  it.timing.response_timeout = ways_.duration(50ms, 120ms);
  it.timing.quarantine.reset();
  it.timing.quarantine_max = 10s;
  it.timing.retries = ways_.between(0U, 2U);
  it.timing.offline_after = 0;
  it.timing.gap = 0ms;
  return it.timing;
}

void ThemeDraw::ask_all_the_time(std::size_t bus, std::size_t device) {
  const unsigned writes = ways_.one_of({0U, 200U, 500U});
  for (unsigned count = ways_.between(2U, 3U); count > 0; --count) {
    Manners asks = client(bus, {device});
    asks.burst = asks.outstanding = ways_.between(1U, 2U);
    asks.pause = ways_.one_of<Duration>({5ms, 50ms, 200ms});
    asks.writes = writes;
    asks.alike = 850;
    asks.stops = ways_.one_of({0U, 0U, 50U});
    plan_.clients.push_back(asks);
  }
}

}  // namespace mbgate::soak

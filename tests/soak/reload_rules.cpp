// SPDX-License-Identifier: Apache-2.0
// Reloads that change times and limits: no request is answered otherwise than it would have been,
// but sooner or later.
#include "soak/reload.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {
constexpr unsigned kAlways = 1000;  // permille
}

// A device that owes an answer is not left alone for a shorter time than before: the answer that
// may still come would be one beyond the quarantine in force.
bool Reloads::change_timing(std::size_t index) {
  drive::Device& device = plan_.settings.devices[index];
  const auto bus = static_cast<std::size_t>(device.bus);
  if (!is_sure(bus)) {
    return false;
  }
  const Duration before = device.timing.quarantine_or_default();
  draw_timing(device.timing);
  if (oracle_.is_quarantined(bus, device.address) &&
      device.timing.quarantine_or_default() < before) {
    device.timing.quarantine = before;
  }
  if (random_.chance(300)) {
    device.cache = random_.chance(500) ? random_.duration(5ms, 200ms) : 0ms;
  }
  if (random_.chance(300) && are_settled(index)) {
    device.stop_cancels = !device.stop_cancels;
    device.split_writes = random_.chance(500);
  }
  devices_[index].adopt(device);
  reload_.touched.push_back(bus);
  return true;
}

void Reloads::draw_timing(drive::DeviceTiming& timing) {
  switch (random_.between(0U, 5U)) {
    case 0: timing.response_timeout = random_.duration(kShortestTimeout, 120ms); break;
    case 1:
      timing.response_wait = random_.chance(400) ? random_.duration(2ms, 30ms) : 0ms;
      timing.gap = random_.chance(400) ? random_.duration(1ms, 10ms) : 0ms;
      break;
    case 2:
      timing.retries = random_.between(0U, 2U);
      timing.retry_writes = random_.chance(100);
      break;
    case 3: timing.stop_retries = random_.between(0U, 3U); break;
    case 4:
      timing.quarantine.reset();
      if (random_.chance(600)) {
        timing.quarantine = random_.chance(100) ? 0ms : random_.duration(10ms, 400ms);
      }
      break;
    default:
      timing.offline_after = random_.between(0U, 4U);
      timing.probe_interval = random_.duration(100ms, 2s);
      timing.probe_timeout.reset();
      if (random_.chance(300)) {
        timing.probe_timeout = random_.duration(kShortestTimeout, 100ms);
      }
  }
}

// Bytes that are on their way come without a gap that is silence now: it becomes no shorter.
bool Reloads::change_rules(std::size_t index) {
  bus::BusSettings& bus = plan_.settings.buses[index];
  reload_.touched.push_back(index);
  switch (random_.between(0U, 5U)) {
    case 0: bus.queue = random_.one_of<std::size_t>({4, 16, 64, 256, 2048}); break;
    case 1: bus.burst = random_.between(1U, 8U); break;
    case 2:
      bus.coalesce = random_.chance(600);
      bus.merge = random_.chance(500);
      break;
    case 3: bus.stop_wait = random_.duration(40ms, 100ms); break;
    case 4:
      bus.turnaround = random_.duration(10ms, 100ms);
      bus.settle = random_.chance(400) ? random_.duration(1ms, 20ms) : 0ms;
      bus.listen_first =
          plan_.restarts_every > 0ms ? bus.listen_first : random_.duration(0ms, 50ms);
      break;
    default:
      if (bus.line.framing == bus::Framing::tcp) {
        bus.outstanding = random_.between(1, 4);
      } else {
        const Duration gap = spec::silence_of(bus);
        bus.frame_gap = random_.duration(gap, std::max<Duration>(gap, 6ms));
      }
  }
  return true;
}

// How long a line is waited for, in its answers and when it is away, and what its server's answers
// have to name. A pause that is within an answer stays within it, and no answer that is on its way
// becomes a wrong one.
bool Reloads::change_patience(std::size_t index) {
  bus::BusSettings& bus = plan_.settings.buses[index];
  reload_.touched.push_back(index);
  switch (patience_.between(0U, 4U)) {
    case 0: bus.reopen_max = patience_.duration(bus.reopen_min, 1s); break;
    case 1: bus.probe_share = patience_.between(10U, 40U); break;
    case 2:
      if (bus.line.framing == bus::Framing::rtu) {
        const Duration slack = spec::slack_of(bus);
        bus.frame_slack = patience_.duration(slack, std::max<Duration>(slack, 250ms));
      }
      break;
    case 3:
      bus.check_unit = !bus.check_unit && plan_.rates[index].other_unit < kAlways &&
                       !oracle_.has_misnamed(index);
      bus.stop_deadline.reset();
      bus.stop_deadline = spec::stop_deadline_of(bus) + patience_.duration(0ms, 1s);
      break;
    default:
      if (bus.replace_after > 0) {
        bus.replace_after = patience_.between(1U, 8U);
      }
  }
  return true;
}

bool Reloads::change_listener(std::size_t index) {
  auto& listener = plan_.settings.listeners[index];
  listener.pipeline = random_.one_of<std::size_t>({1, 4, 16, 64});
  listener.ordered = random_.chance(250);  // of connections that come from then on
  listener.frame_timeout = random_.duration(1s, 10s);
  return true;
}

// Where the last of them are lifted, what was held up goes on.
bool Reloads::change_host_limits(std::size_t index) {
  gateway::ListenerSettings& listener = plan_.settings.listeners[index];
  if (listener.max_requests_per_second > 0 && host_limits_.chance(400)) {
    listener.max_requests_per_second = 0;
  } else {
    draw_client_limits(listener, host_limits_);
  }
  return true;
}

bool Reloads::change_idle(std::size_t index) {
  plan_.settings.listeners[index].idle_timeout =
      random_.chance(300) ? 0ms : random_.duration(300ms, 3s);
  reload_.idle.push_back(index);
  return true;
}

bool Reloads::change_deadline(std::size_t index) {
  routing::Route& route = plan_.settings.routes[index];
  if (route.is_broadcast() || !is_sure(static_cast<std::size_t>(route.buses.front()))) {
    return false;
  }
  route.deadline.reset();
  if (random_.chance(500)) {
    route.deadline = random_.duration(50ms, 3s);
  }
  return true;
}

bool Reloads::change_failsafe(std::size_t index) {
  if (plan_.failsafe[index].empty()) {
    return false;
  }
  draw_failsafe(plan_, index, random_);
  return true;
}

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
// What one seed's listeners put up with: so many connections, so long a silence; who may only read;
// clients that hang. With a chance of its own, so that plants and clients stay those of the seed.
#include <algorithm>

#include "soak/pdus.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr std::uint64_t kLimitsChance = 0x4C494D495453ULL;
constexpr std::uint64_t kReadersChance = 0x5245414445ULL;
constexpr std::uint64_t kAddressChance = 0x41444452455353ULL;
constexpr std::uint64_t kCrowdsChance = 0x43524F574453ULL;

void draw_listener(SoakPlan& plan, gateway::ListenerSettings& listener, Random& random) {
  std::vector<unsigned>& kept = plan.kept.emplace_back();
  plan.allowed.emplace_back();
  plan.idle_from.push_back(Instant::min());
  if (random.chance(250)) {
    listener.max_connections = random.one_of<std::size_t>({1, 2, 4, 8});
    for (unsigned host = 0; host < kMostHosts; ++host) {
      if (random.chance(200)) {
        kept.push_back(host);
      }
    }
    listener.keep = networks_of(kept);
  }
  if (random.chance(300)) {
    listener.idle_timeout = random.duration(300ms, 3s);
  }
  if (random.chance(500)) {
    listener.frame_timeout = random.duration(kLeastFrameTimeout, 3s);
  }
  std::vector<unsigned>& readers = plan.readers.emplace_back();
  // Who is gone, of those that may write, is a question of its own: draw_readers().
  for (unsigned host = 0; !is_guarded(plan) && host < kMostHosts && random.chance(300); host += 3) {
    readers.push_back(host);
  }
  listener.read_only = networks_of(readers);
}

// They hold off no failsafe writes.
void draw_readers(SoakPlan& plan, Random& random) {
  if (!is_guarded(plan) || !random.chance(400)) {
    return;
  }
  for (std::size_t listener = 0; listener < plan.readers.size(); ++listener) {
    for (unsigned host = 0; host < kMostHosts; ++host) {
      if (random.chance(200)) {
        plan.readers[listener].push_back(host);
      }
    }
    plan.settings.listeners[listener].read_only = networks_of(plan.readers[listener]);
  }
}

}  // namespace

void draw_limits(SoakPlan& plan, std::uint64_t seed) {
  Random random(seed ^ kLimitsChance);
  for (gateway::ListenerSettings& listener : plan.settings.listeners) {
    draw_listener(plan, listener, random);
  }
  Random of_readers(seed ^ kReadersChance);
  draw_readers(plan, of_readers);
  Random of_addresses(seed ^ kAddressChance);
  for (gateway::ListenerSettings& listener : plan.settings.listeners) {
    if (of_addresses.chance(200)) {
      listener.max_connections_per_address = of_addresses.one_of<std::size_t>({1, 2, 3});
    }
  }
  for (gateway::DeviceGuard& guard : plan.settings.guards) {
    guard.failsafe_on_exit = !guard.failsafe.empty() && random.chance(400);
  }
  plan.stops_early = random.chance(300);
  // On a slow line broadcasts and stops in crowds would wait for minutes.
  const bool is_slow = std::ranges::any_of(
      plan.settings.buses, [](const auto& bus) { return bus.line.baud < modbus::Baud{9600}; });
  for (Manners& manners : plan.clients) {
    const bool is_odd = !plan.silence && random.chance(300);
    manners.hangs = is_odd ? random.one_of({0U, 3U, 20U}) : 0;
    manners.loses_framing = is_odd ? random.one_of({0U, 3U, 20U}) : 0;
    manners.rests = is_odd ? random.one_of({0U, 20U}) : 0;
    manners.stops = std::min(manners.stops, is_slow ? 10U : manners.stops);
    manners.broadcasts = std::min(manners.broadcasts, is_slow ? 5U : manners.broadcasts);
    manners.waits_at_start = !manners.never_asks && random.chance(200);
  }
  // So much at once that the gateway pauses while several pieces are left to be read.
  Random of_crowds(seed ^ kCrowdsChance);
  if (!plan.silence && !is_slow && of_crowds.chance(100)) {
    Manners& manners = plan.clients[of_crowds.below(plan.clients.size())];
    manners.outstanding = 600;
    manners.burst = 300;
  }
}

}  // namespace mbgate::soak

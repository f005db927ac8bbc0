// SPDX-License-Identifier: Apache-2.0
// Plants in which one host may connect and ask only so often, and some do so more often. With a
// chance of its own, so that all other plants and clients stay those of the seed.
#include <algorithm>

#include "soak/plan.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr std::uint64_t kClientRatesChance = 0x434C52415445ULL;
constexpr std::size_t kMostClients = 8;  // the last one's turn comes before anybody gets impatient
constexpr unsigned kMostOutstanding = 12;

// Who owns writing, and who is left to write, depends on when requests are taken. Where silence is
// judged nobody goes who may be held up.
bool fits(const SoakPlan& plan) {
  return plan.theme == Theme::none && plan.rules.empty() && (plan.silence || !is_guarded(plan)) &&
         std::ranges::none_of(plan.settings.guards, [](const gateway::DeviceGuard& guard) {
           return guard.writer == gateway::WriterRule::first;
         });
}

void draw_manners(const SoakPlan& plan, Manners& manners, Random& random) {
  const unsigned rate = plan.settings.listeners[manners.listener].max_requests_per_second;
  manners.malformed = random.one_of({50U, 200U});
  if (plan.silence) {
    manners.vanishes = manners.never_asks ? manners.vanishes : 0;
    // Behind answers that it does not take it is silent, and nobody outside knows which of its
    // requests were held up before these filled the pipeline.
    manners.half_closes = manners.stalls = 0;
  }
  if (rate == 0 || manners.never_asks) {
    return;
  }
  if (random.chance(600)) {  // it asks for more than it gets
    manners.burst = random.one_of({1U, 4U, 2 * rate});
    manners.outstanding = 2 * rate;
    manners.least_pause = 1ms;
    manners.pause = random.one_of<Duration>({5ms, 50ms, 300ms});
  }
  manners.outstanding = std::clamp(manners.outstanding, 1U, std::min(2 * rate, kMostOutstanding));
  manners.burst = std::min(manners.burst, manners.outstanding);
}

// It comes and goes, also where others come from who ask.
Manners visitor(const SoakPlan& plan, Random& random) {
  const Manners& other = plan.clients[random.below(plan.clients.size())];
  Manners manners;
  manners.listener = other.listener;
  manners.host = other.host;
  manners.role = other.role;
  manners.never_asks = true;
  manners.least_pause = 1ms;
  manners.pause = random.one_of<Duration>({20ms, 200ms});
  manners.vanishes = random.one_of({200U, 700U});
  return manners;
}

}  // namespace

void draw_client_limits(gateway::ListenerSettings& listener, Random& random) {
  listener.max_requests_per_second =
      random.chance(800) ? random.one_of({1U, 2U, 3U, 5U, 10U, 20U}) : 0U;
  listener.max_connects_per_second = random.chance(700) ? random.one_of({1U, 2U, 3U, 5U, 10U}) : 0U;
}

void draw_client_rates(SoakPlan& plan, std::uint64_t seed) {
  Random random(seed ^ kClientRatesChance);
  if (!fits(plan) || !random.chance(plan.silence ? 800 : 500)) {
    return;
  }
  plan.limits_hosts = true;
  for (gateway::ListenerSettings& listener : plan.settings.listeners) {
    draw_client_limits(listener, random);
    listener.idle_timeout = plan.silence ? 0ms : listener.idle_timeout;
  }
  plan.clients.resize(std::min(plan.clients.size(), kMostClients));
  for (Manners& manners : plan.clients) {
    draw_manners(plan, manners, random);
  }
  for (unsigned count = random.between(0U, 2U); count > 0; --count) {
    plan.clients.push_back(visitor(plan, random));
  }
}

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
// Plants whose routes have windows that reloads move, while much waits behind full pipelines. With
// a chance of its own, so that all other plants stay those of the seed.
#include <algorithm>

#include "soak/plan.hpp"
#include "soak/registers.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr std::uint64_t kPlantChance = 0x504C57494E44ULL;

void give_windows(SoakPlan& plan, std::size_t index, Random& random) {
  constexpr unsigned kMiddle = kAddresses / 2;
  routing::Route& route = plan.settings.routes[index];
  Door shown;
  shown.holding_at = random.between(0U, kMiddle - kRegisters);
  shown.input_at = random.between(kMiddle, kAddresses - kInputs);
  shown.coils_at = random.between(0U, kAddresses - kCoils);
  set_windows(route, shown);
  route.functions = routing::FunctionRules::rewritable();
  for (Door& door : plan.doors) {
    if (door.route == index) {
      door.windowed = true;
      door.holding_at = shown.holding_at;
      door.input_at = shown.input_at;
      door.coils_at = shown.coils_at;
    }
  }
}

}  // namespace

void draw_windows(SoakPlan& plan, std::uint64_t seed) {
  Random random(seed ^ kPlantChance);
  const bool is_guarded =
      std::ranges::any_of(plan.settings.guards, [](const gateway::DeviceGuard& guard) {
        return guard.writer != gateway::WriterRule::any || !guard.failsafe.empty();
      });
  if (plan.theme != Theme::none || plan.silence || is_guarded || !random.chance(250)) {
    return;
  }
  plan.moves_windows = true;
  for (std::size_t index = 0; index < plan.settings.routes.size(); ++index) {
    const routing::Route& route = plan.settings.routes[index];
    if (route.device && route.windows.empty() && random.chance(700)) {
      give_windows(plan, index, random);
    }
  }
  auto& listeners = plan.settings.listeners;
  for (gateway::ListenerSettings& listener : listeners) {
    listener.pipeline = listener.bus ? listener.pipeline : random.one_of({1U, 2U, 4U});
  }
  for (Manners& manners : plan.clients) {
    if (!listeners[manners.listener].bus) {
      manners.burst = manners.outstanding = std::max(manners.burst, random.between(4U, 12U));
      manners.writes = std::max(manners.writes, 200U);
    }
  }
}

}  // namespace mbgate::soak

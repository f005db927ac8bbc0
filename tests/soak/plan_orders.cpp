// SPDX-License-Identifier: Apache-2.0
// Plants of which nobody has said in which order drives speak the words of values: no route names
// an order there, nothing is exchanged, and what is for several of them must not touch a value.
// With a chance of its own, so that plants and clients stay those of the seed.
#include <algorithm>

#include "soak/plan.hpp"

namespace mbgate::soak {

namespace {

constexpr std::uint64_t kOrdersChance = 0x4F52444552ULL;
constexpr unsigned kFew = 4;  // requests at once: others would ask for nothing but stops

}  // namespace

void draw_orders(SoakPlan& plan, std::uint64_t seed) {
  Random random(seed ^ kOrdersChance);
  if (!random.chance(160)) {
    return;
  }
  for (drive::Device& device : plan.settings.devices) {
    if (random.chance(800)) {
      device.word_order.reset();
      device.verify_word_order = false;
    }
  }
  for (routing::Route& route : plan.settings.routes) {
    route.word_order.reset();
  }
  for (Door& door : plan.doors) {
    door.names_order = door.swapped = false;
  }
  const unsigned more = plan.silence ? 0 : random.one_of({0U, 100U, 300U});
  for (Manners& manners : plan.clients) {
    if (manners.outstanding <= kFew) {
      manners.broadcasts = std::max(manners.broadcasts, more);
    }
  }
}

}  // namespace mbgate::soak

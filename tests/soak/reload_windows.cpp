// SPDX-License-Identifier: Apache-2.0
// Reloads that move the windows of a route: what its clients wrote for a register means another one
// from then on, or none. What the gateway has taken before goes to the register that was meant.
#include <algorithm>
#include <utility>

#include "soak/reload.hpp"

namespace mbgate::soak {

bool Reloads::move_windows(std::size_t index) {
  routing::Route& route = plan_.settings.routes[index];
  if (route.windows.empty() || plan_.absent.routes[index] || !is_route_settled(index)) {
    return false;
  }
  const auto first =
      std::ranges::find_if(plan_.doors, [&](const Door& door) { return door.route == index; });
  Door moved = *first;
  if (!redraw_windows(moved)) {
    return false;
  }
  for (Door& door : plan_.doors) {
    if (door.route == index) {
      door.holding_at = moved.holding_at;
      door.input_at = moved.input_at;
      door.coils_at = moved.coils_at;
      door.shows_coils = moved.shows_coils;
      ++door.moves;
    }
  }
  set_windows(route, moved);
  return true;
}

// Mostly by a little, so that what was asked for lies in a window still.
bool Reloads::redraw_windows(Door& door) {
  constexpr unsigned kMiddle = kAddresses / 2;
  constexpr unsigned kLittle = 20;
  const auto move = [&](unsigned& at, unsigned lowest, unsigned highest) {
    const bool is_near = windows_.chance(700);
    const unsigned from = is_near ? std::max(at, lowest + kLittle) - kLittle : lowest;
    const unsigned to = is_near ? std::min(at + kLittle, highest) : highest;
    const unsigned before = std::exchange(at, windows_.between(from, to));
    return at != before;
  };
  switch (windows_.between(0U, 3U)) {
    case 0: return move(door.input_at, kMiddle, kAddresses - kInputs);
    case 1:
      if (windows_.chance(500)) {
        door.shows_coils = !door.shows_coils;
        door.coils_at = 0;
        return true;
      }
      return door.shows_coils && move(door.coils_at, 0, kAddresses - kCoils);
    default: return move(door.holding_at, 0, kMiddle - kRegisters);
  }
}

}  // namespace mbgate::soak

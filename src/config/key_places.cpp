// SPDX-License-Identifier: Apache-2.0
#include "config/key_places.hpp"

#include "config/sections/sections.hpp"

namespace mbgate::config {
namespace {

std::string place_of_key(const Draft& draft, TomlTable& table, std::string_view key) {
  return table.has(key) ? line_of(draft, table.value_position(key)) : std::string();
}

RoutePlaces places_of_route(const Draft& draft, TomlTable& table) {
  auto windows = table.tables("registers");
  return {line_of(draft, table.value_position("access")),
          line_of(draft, table.value_position("functions")),
          line_of(draft, windows.empty() ? table.position() : windows.front().position())};
}

}  // namespace

KeyPlaces find_key_places(Draft& draft) {
  KeyPlaces places;
  for (TomlTable& table : draft.listeners) {
    places.listeners.push_back(
        {place_of_key(draft, table, "allow"), place_of_key(draft, table, "read_only")});
  }
  for (TomlTable& table : draft.routes) {
    places.routes.push_back(places_of_route(draft, table));
  }
  for (TomlTable& table : draft.devices) {
    places.writers.push_back(place_of_key(draft, table, "writer"));
  }
  return places;
}

}  // namespace mbgate::config

// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <fmt/core.h>

#include "app/changes.hpp"
#include "config/toml/match_entry.hpp"
#include "config/toml/toml_value.hpp"

namespace mbgate::app {
namespace {

using gateway::Settings;
using routing::AddressWindow;
using routing::Route;

std::string range_of(std::uint32_t first, std::uint32_t last) {
  return std::to_string(first) + (first == last ? "" : fmt::format("..{}", last));
}

std::string title_of(const Settings& settings, const Route& route) {
  const bool is_one = route.first_unit == route.last_unit;
  return fmt::format(
      "{}{}{}", is_one ? "route of unit " : "route of units ",
      range_of(route.first_unit, route.last_unit),
      route.listener ? fmt::format(" (listener {})", settings.listener(*route.listener).name) : "");
}

std::string target_of(const Settings& settings, const Route& route) {
  if (route.device) {
    return "device " + settings.devices[*route.device].name;
  }
  std::string text;
  for (const drive::BusId bus : route.buses) {
    text += (text.empty() ? "bus " : ", ") + settings.bus(bus).name;
  }
  return route.is_broadcast() ? text : fmt::format("{} from address {}", text, route.first_address);
}

std::string functions_of(const Settings& settings, const Route& route) {
  const bool has_delimiter = std::ranges::any_of(route.buses, [&](drive::BusId bus) {
    return settings.bus(bus).line.framing == bus::Framing::ascii;
  });
  auto all = routing::FunctionRules::all();
  all.change_delimiter = !has_delimiter;
  if (route.functions == all) {
    return "all";
  }
  std::string text;
  const auto& allowed = route.functions.allowed;
  for (std::size_t function = 1; function < allowed.size(); ++function) {
    if (allowed.test(function)) {
      text += (text.empty() ? "" : " ") + std::to_string(function);
    }
  }
  text += route.functions.restart_communications ? " 8/1" : "";
  text += route.functions.change_delimiter && (has_delimiter || !allowed.test(8)) ? " 8/3" : "";
  text += route.functions.force_listen_only ? " 8/4" : "";
  return text.substr(text.starts_with(' ') ? 1 : 0);
}

std::string windows_of(const Route& route) {
  std::string text;
  for (const AddressWindow& window : route.windows) {
    text += fmt::format("{}{} {}={} {}", text.empty() ? "" : " ", config::table_word(window.table),
                        range_of(window.from, window.from + window.count - 1),
                        config::table_word(window.to_table), window.to);
  }
  return text.empty() ? "all" : text;
}

std::string order_of(const Route& route) {
  return route.word_order ? std::string(config::order_word(*route.word_order)) : "-";
}

/// What a client may see of a route, by its keys.
std::vector<std::pair<const char*, std::string>> keys_of(const Settings& settings,
                                                         const Route& route) {
  return {{"", target_of(settings, route)},
          {"access ", route.access == routing::Access::read_only ? "read-only" : "read-write"},
          {"functions ", functions_of(settings, route)},
          {"registers ", windows_of(route)},
          {"word_order ", order_of(route)},
          {"deadline ", route.deadline ? config::to_text(*route.deadline) : "-"},
          {"broadcast_reply ",
           route.broadcast_reply == routing::BroadcastReply::none ? "none" : "echo"},
          {"broadcast_mixed ", route.broadcast_mixed ? "true" : "false"}};
}

std::string differences_of(const Settings& old, const Route& before, const Settings& next,
                           const Route& after) {
  const auto was = keys_of(old, before);
  const auto is = keys_of(next, after);
  std::string text;
  for (std::size_t key = 0; key < is.size(); ++key) {
    if (was[key].second != is[key].second) {
      text += fmt::format("{}{}{} -> {}", text.empty() ? "" : ", ", is[key].first, was[key].second,
                          is[key].second);
    }
  }
  return text.empty() ? "functions of its own" : text;  // named now, or no more
}

std::vector<Route> without(std::vector<Route> routes, const std::vector<Route>& others) {
  for (const Route& other : others) {
    if (const auto same = std::ranges::find(routes, other); same != routes.end()) {
      routes.erase(same);
    }
  }
  return routes;
}

}  // namespace

std::vector<std::string> route_changes(const Settings& old, const Settings& next) {
  std::vector<std::string> changes;
  std::vector<Route> gone = without(old.routes, next.routes);
  for (const Route& route : without(next.routes, old.routes)) {
    const auto before = std::ranges::find_if(gone, [&](const Route& it) {
      return it.listener == route.listener && it.first_unit == route.first_unit &&
             it.last_unit == route.last_unit;
    });
    const std::string title = title_of(next, route);
    if (before == gone.end()) {
      changes.push_back(fmt::format("{} added: {}", title, target_of(next, route)));
    } else {
      changes.push_back(fmt::format("{}: {}", title, differences_of(old, *before, next, route)));
      gone.erase(before);
    }
  }
  for (const Route& route : gone) {
    changes.push_back(fmt::format("{} removed: {}", title_of(old, route), target_of(old, route)));
  }
  return changes;
}

}  // namespace mbgate::app

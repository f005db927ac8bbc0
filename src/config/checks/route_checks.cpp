// SPDX-License-Identifier: Apache-2.0
// Routes against the drives that they reach.
#include <algorithm>
#include <fmt/core.h>

#include "config/sections/sections.hpp"
#include "config/toml/match_entry.hpp"

namespace mbgate::config {
namespace {

using drive::BroadcastForm;
using drive::Device;
using modbus::Table;
using routing::AddressWindow;

bool has_values(const Device& device) { return !device.profile.values.all().empty(); }

/// A route can give values an order only if the order of the device is known.
void check_order_known(Draft& draft, std::size_t route, std::size_t at) {
  const auto& device = draft.settings.devices[at];
  if (!draft.profile_known[at] || !has_values(device) || device.word_order) {
    return;
  }
  draft.routes[route].error(
      "word_order", "the word order of " + in_quotes(device.name) +
                        R"( is not configured: add word_order = "big" or "little" to it at )" +
                        draft.devices[at].place_of("name"));
}

/// A forgotten profile would leave every value in the drive's own order without a word.
void check_order_matters(Draft& draft, std::size_t route, std::size_t at) {
  const auto& device = draft.settings.devices[at];
  if (draft.profile_known[at] && !has_values(device)) {
    draft.routes[route].warning(
        "word_order",
        "changes nothing: no values of {} are known; give it a 'profile' that has them, or "
        "'values32'",
        in_quotes(device.name));
  }
}

void check_word_order(Draft& draft, std::size_t at) {
  const auto& route = draft.settings.routes[at];
  if (!route.word_order) {
    return;
  }
  if (route.device) {
    check_order_known(draft, at, *route.device);
    check_order_matters(draft, at, *route.device);
    return;
  }
  for (std::size_t i = 0; route.is_broadcast() && i < draft.settings.devices.size(); ++i) {
    if (std::ranges::find(route.buses, draft.settings.devices[i].bus) != route.buses.end()) {
      check_order_known(draft, at, i);
    }
  }
}

/// The value that has registers on both sides of the border before `address`; nullptr if none has.
const drive::Value* value_across(const Device& device, Table table, std::uint32_t address) {
  const auto* value = device.profile.values.at(device.profile.described_in(table), address);
  return value != nullptr && value->first < address ? value : nullptr;
}

void check_window(const Device& device, const AddressWindow& window, TomlTable& entry) {
  const auto text = [&](const drive::Value& value) {
    return fmt::format(" within the value {} to {} of {}", value.first, value.end() - 1,
                       in_quotes(device.name));
  };
  if (const auto* value = value_across(device, window.to_table, window.to)) {
    entry.error("to", "the window begins" + text(*value));
  }
  if (const auto* value = value_across(device, window.to_table, window.to + window.count)) {
    entry.error("count", "the window ends" + text(*value));
  }
}

/// Its entries and its windows are the same as long as no window is wrong.
void check_windows(Draft& draft, std::size_t at) {
  const auto& route = draft.settings.routes[at];
  auto entries = draft.routes[at].tables("registers");
  if (entries.size() != route.windows.size()) {
    return;
  }
  for (std::size_t i = 0; i < draft.settings.devices.size(); ++i) {
    const auto& device = draft.settings.devices[i];
    const bool reached = route.is_broadcast()
                             ? std::ranges::find(route.buses, device.bus) != route.buses.end()
                             : route.device == i;
    for (std::size_t entry = 0; reached && entry < entries.size(); ++entry) {
      check_window(device, route.windows[entry], entries[entry]);
    }
  }
}

/// Where the manual states no broadcasts, the drive may well listen to the standard's.
BroadcastForm heard_form(const Device& device) {
  return device.profile.broadcast.form.value_or(BroadcastForm{});
}

}  // namespace

void check_routes(Draft& draft) {
  for (std::size_t at = 0; at < draft.settings.routes.size(); ++at) {
    check_word_order(draft, at);
    check_windows(draft, at);
  }
}

void check_broadcast_mixed(Draft& draft, TomlTable& table, std::string_view key,
                           const std::vector<drive::BusId>& buses) {
  std::vector<BroadcastForm> forms;
  for (const Device& device : draft.settings.devices) {
    if (std::ranges::find(forms, heard_form(device)) == forms.end()) {
      forms.push_back(heard_form(device));
    }
  }
  for (const auto form : forms) {
    const Device* first = nullptr;
    for (std::size_t i = 0; i < draft.settings.devices.size(); ++i) {
      const auto& device = draft.settings.devices[i];
      if (std::ranges::find(buses, device.bus) == buses.end() || !draft.profile_known[i] ||
          heard_form(device) != form) {
        continue;
      }
      if (first == nullptr) {
        first = &device;
      } else if (first->profile.name != device.profile.name) {
        table.warning(
            key,
            "{} ({}) and {} ({}) hear the same broadcast, and a register means different things to "
            "them: only stops are sent; broadcast_mixed = true permits all broadcasts",
            in_quotes(first->name), first->profile.name, in_quotes(device.name),
            device.profile.name);
        break;
      }
    }
  }
}

}  // namespace mbgate::config

// SPDX-License-Identifier: Apache-2.0
#include "app/changes.hpp"

#include <algorithm>
#include <concepts>
#include <fmt/core.h>
#include <iterator>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

#include "base/text.hpp"
#include "config/keys/keys.hpp"
#include "config/toml/match_entry.hpp"

namespace mbgate::app {
namespace {

using bus::BusSettings;
using config::PlainKey;
using drive::Device;
using gateway::DeviceGuard;
using gateway::ListenerSettings;
using gateway::Settings;

// What is short enough to be told: numbers, names and words, as they stand in the file.
std::string text_of(std::integral auto value) { return config::value_text(value); }
std::string text_of(std::string_view value) { return fmt::format("\"{}\"", value); }
std::string text_of(bus::Framing framing) {
  return text_of(config::word_for(config::kFramings, framing));
}
std::string text_of(modbus::Parity parity) {
  return text_of(config::word_for(config::kParities, parity));
}
std::string text_of(drive::WordOrder order) { return text_of(config::order_word(order)); }
std::string text_of(const bus::Endpoint& end) { return host_and_port(end.host, end.port); }
template <typename Value>
auto text_of(const std::optional<Value>& value) -> decltype(text_of(*value)) {
  return value ? text_of(*value) : config::value_text({});
}

/// The keys of one section that differ.
class Differences {
 public:
  template <typename Section>
  void compare(std::span<const PlainKey<Section>> keys, const std::type_identity_t<Section>& old,
               const std::type_identity_t<Section>& next) {
    for (const auto& key : keys) {
      const auto before = key.get(old);
      const auto after = key.get(next);
      if (before != after) {
        add(fmt::format("{} {} -> {}", key.name, config::value_text(before),
                        config::value_text(after)));
      }
    }
  }
  /// Values that are too long are not told.
  template <typename Value>
  void compare(const char* key, const Value& old, const Value& next) {
    if (old == next) {
      return;
    }
    if constexpr (requires { text_of(old); }) {
      add(fmt::format("{} {} -> {}", key, text_of(old), text_of(next)));
    } else {
      add(key);
    }
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  void add(const std::string& difference) { text_ += (text_.empty() ? "" : ", ") + difference; }
  std::string text_;
};

std::optional<std::string> name_of(const Settings& settings, std::optional<gateway::BusId> bus) {
  return bus ? std::optional(settings.bus(*bus).name) : std::nullopt;
}

std::optional<gateway::TlsSettings> tls_of(const Settings& settings,
                                           const ListenerSettings& listener) {
  return listener.tls ? std::optional(settings.tls[*listener.tls]) : std::nullopt;
}

std::string differences(const Settings& old, const Settings& next, std::size_t number,
                        const ListenerSettings& /*kind*/) {
  const ListenerSettings& a = old.listeners[number];
  const ListenerSettings& b = next.listeners[number];
  Differences found;
  found.compare("address", a.address, b.address);
  found.compare("port", a.port, b.port);
  found.compare(config::listener_keys(), a, b);
  found.compare("allow", a.allow, b.allow);
  found.compare("read_only", a.read_only, b.read_only);
  found.compare("keep", a.keep, b.keep);
  found.compare("identity", a.counts_certificates, b.counts_certificates);
  found.compare("tls", tls_of(old, a), tls_of(next, b));
  found.compare("bus", name_of(old, a.bus), name_of(next, b.bus));
  found.compare("broadcast_reply", a.broadcast_reply, b.broadcast_reply);
  found.compare("broadcast_mixed", a.broadcast_mixed, b.broadcast_mixed);
  return found.text();
}

std::string differences(const Settings& old, const Settings& next, std::size_t number,
                        const BusSettings& /*kind*/) {
  const BusSettings& a = old.buses[number];
  const BusSettings& b = next.buses[number];
  Differences found;
  found.compare("mode", a.line.framing, b.line.framing);
  found.compare("device", a.line.device, b.line.device);
  if (a.line.device == b.line.device) {
    found.compare("host or port", a.line.remote, b.line.remote);
    found.compare("tls", a.line.tls, b.line.tls);
  }
  found.compare(config::bus_keys(), a, b);
  found.compare("data_bits", a.line.format.data_bits, b.line.format.data_bits);
  found.compare("parity", a.line.format.parity, b.line.format.parity);
  found.compare("rs485", a.line.rs485, b.line.rs485);
  found.compare("echo", a.line.echo, b.line.echo);
  found.compare("paced", a.line.paced, b.line.paced);
  found.compare(config::timing_keys(), a.timing, b.timing);
  return found.text();
}

/// The new times of a device, without what only follows its bus, which is told there.
drive::DeviceTiming times_after(const Settings& old, const Settings& next, std::size_t device) {
  const Device& a = old.devices[device];
  drive::DeviceTiming times = next.devices[device].timing;
  if (a.bus != next.devices[device].bus) {
    return times;
  }
  const auto& before = old.bus(a.bus).timing;
  const auto& after = next.bus(a.bus).timing;
  for (const auto& key : config::timing_keys()) {
    if (key.get(a.timing) == key.get(before) && key.get(times) == key.get(after)) {
      key.set(times, key.get(a.timing));
    }
  }
  return times;
}

DeviceGuard guard_of(const Settings& settings, std::size_t device) {
  return device < settings.guards.size() ? settings.guards[device] : DeviceGuard();
}

std::vector<modbus::Pdu> pdus(const std::vector<modbus::Request>& requests) {
  std::vector<modbus::Pdu> found;
  found.reserve(requests.size());
  for (const auto& request : requests) {
    found.push_back(request.pdu());
  }
  return found;
}

std::string_view echo_word(const Device& device) {
  return config::word_for(config::kEchoes, device.limits_values);
}

std::string differences(const Settings& old, const Settings& next, std::size_t number,
                        const Device& /*kind*/) {
  const Device& a = old.devices[number];
  const Device& b = next.devices[number];
  const DeviceGuard guarded = guard_of(old, number);
  const DeviceGuard guards = guard_of(next, number);
  Differences found;
  found.compare("bus", old.bus(a.bus).name, next.bus(b.bus).name);
  found.compare("address", a.address, b.address);
  found.compare("profile", a.profile.name, b.profile.name);
  if (a.profile.name == b.profile.name) {
    found.compare("profile or values of its own", a.profile, b.profile);
  }
  found.compare("word_order", a.word_order, b.word_order);
  found.compare("opcode_order", a.opcode_order, b.opcode_order);
  found.compare("write_function", a.write_function, b.write_function);
  found.compare("write_echo", echo_word(a), echo_word(b));
  found.compare(config::device_keys(), a, b);
  found.compare(config::timing_keys(), a.timing, times_after(old, next, number));
  found.compare("writer", guarded.writer, guards.writer);
  found.compare("writer's clients", guarded.writers, guards.writers);
  found.compare("failsafe_clients", guarded.failsafe_clients, guards.failsafe_clients);
  found.compare("failsafe", pdus(guarded.failsafe), pdus(guards.failsafe));
  found.compare(config::guard_keys(), guarded, guards);
  return found.text();
}

bool is_gone(const Device& device) { return device.is_gone(); }
bool is_gone(const auto& named) { return named.is_gone; }

template <typename Named>
void compare_all(std::vector<std::string>& changes, const char* kind, const Settings& old,
                 const Settings& next, std::vector<Named> Settings::*member) {
  const std::vector<Named>& before = old.*member;
  const std::vector<Named>& after = next.*member;
  for (std::size_t number = 0; number < after.size(); ++number) {
    const bool was = number < before.size() && !is_gone(before[number]);
    const bool is = !is_gone(after[number]);
    const std::string name = fmt::format("{} {}", kind, after[number].name);
    if (was != is) {
      changes.push_back(name + (is ? " added" : " removed"));
    } else if (is) {
      if (const std::string found = differences(old, next, number, Named()); !found.empty()) {
        changes.push_back(fmt::format("{}: {}", name, found));
      }
    }
  }
}

/// They may stand at other lines of the file.
bool is_same(routing::AccessRule a, routing::AccessRule b) {
  a.place.clear();
  b.place.clear();
  return a == b;
}

/// The titles of those that are not among the others.
std::string titles_without(const std::vector<routing::AccessRule>& rules,
                           const std::vector<routing::AccessRule>& others) {
  std::string titles;
  for (const routing::AccessRule& rule : rules) {
    if (std::ranges::none_of(others, [&](const auto& other) { return is_same(rule, other); })) {
      titles += (titles.empty() ? "" : ", ") + rule.title();
    }
  }
  return titles;
}

void add_rules(std::vector<std::string>& changes, const std::vector<routing::AccessRule>& old,
               const std::vector<routing::AccessRule>& next) {
  if (std::ranges::equal(old, next, is_same)) {
    return;
  }
  const std::string gone = titles_without(old, next);
  const std::string come = titles_without(next, old);
  changes.push_back(gone.empty() && come.empty()
                        ? "access rules: their order or number has changed"
                        : fmt::format("access rules: {} -> {}", gone.empty() ? "none" : gone,
                                      come.empty() ? "none" : come));
}

}  // namespace

std::vector<std::string> changes_between(const Settings& old, const Settings& next) {
  std::vector<std::string> changes;
  Differences gateway;
  gateway.compare("unit", old.status_unit, next.status_unit);
  gateway.compare("signer", old.signer, next.signer);
  gateway.compare(config::gateway_keys(), old, next);
  if (!gateway.text().empty()) {
    changes.push_back("gateway: " + gateway.text());
  }
  Differences http;
  http.compare("listen", old.http.listen, next.http.listen);
  http.compare("allow", old.http.allow, next.http.allow);
  http.compare("hosts", old.http.hosts, next.http.hosts);
  http.compare(config::http_keys(), old.http, next.http);
  if (!http.text().empty()) {
    changes.push_back("http: " + http.text());
  }
  compare_all(changes, "listener", old, next, &Settings::listeners);
  compare_all(changes, "bus", old, next, &Settings::buses);
  compare_all(changes, "device", old, next, &Settings::devices);
  std::ranges::move(route_changes(old, next), std::back_inserter(changes));
  add_rules(changes, old.rules, next.rules);
  if (!(old.weights == next.weights)) {
    changes.emplace_back("clients: weights");
  }
  return changes;
}

}  // namespace mbgate::app

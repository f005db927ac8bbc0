// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <fmt/core.h>
#include <string_view>

#include "base/text.hpp"
#include "config/load.hpp"
#include "config/sections/sections.hpp"
#include "config/toml/toml_value.hpp"
#include "gateway/limits.hpp"

namespace mbgate::config {
namespace {

// What becomes of a request that no rule matches, or that the last one decides for all.
std::string rules_text(const gateway::Settings& settings) {
  const auto& rules = settings.rules;
  const routing::AccessRule& last = rules.back();
  const bool any_role = std::ranges::any_of(settings.listeners,
                                            [](const auto& listener) { return has_tls(listener); });
  const bool decides_all = hides(last, routing::AccessRule{.any_role = any_role});
  const std::string end = decides_all
                              ? fmt::format("the last one, {}, {} all other requests", last.title(),
                                            last.permits ? "permits" : "denies")
                              : std::string("requests that match none of them are denied");
  return fmt::format("{}: {}", counted(rules.size(), "rule", "rules"), end);
}

// What the units of a Modbus TCP server are, where one device stands for it.
std::string units_text(const gateway::Settings& settings) {
  std::string text;
  for (std::size_t at = 0; at < settings.buses.size(); ++at) {
    const auto devices = settings.devices_on(drive::BusId{static_cast<std::uint32_t>(at)});
    if (settings.buses[at].line.framing == bus::Framing::tcp && devices.size() == 1) {
      const drive::Device& device = devices.front();
      text += fmt::format("\nbus {}: {}", settings.buses[at].name,
                          device.has_every_unit
                              ? "every unit is device " + device.name
                              : fmt::format("device {} is unit {} alone; if all units are this "
                                            "device, set one_device = true",
                                            device.name, device.address));
    }
  }
  return text;
}

// How soon a stop is sent; by identifiers its answer is known among others.
std::string stop_text(const bus::BusSettings& bus, std::vector<drive::Device> devices) {
  const std::string wait =
      bus.has_identifiers() ? "at once"
                            : "within " + rounded(bus::longest_stop_wait(bus, std::move(devices)));
  return bus.connect_delay == bus::Duration{0}
             ? wait
             : fmt::format("{}, on a new connection after connect_delay ({})", wait,
                           to_text(bus.connect_delay));
}

// How long writes may wait for their turn on each bus, and stops for the line.
std::string waits_text(const gateway::Settings& settings) {
  std::string text;
  for (std::size_t at = 0; at < settings.buses.size(); ++at) {
    const bus::BusSettings& bus = settings.buses[at];
    const auto devices = settings.devices_on(drive::BusId{static_cast<std::uint32_t>(at)});
    const bus::Duration longest = bus::longest_transaction(bus, devices);
    text += fmt::format("\nbus {}: writes have {} by default; a stop is sent {}", bus.name,
                        rounded(gateway::write_deadline(longest)), stop_text(bus, devices));
  }
  return text;
}

/// Below it a port takes a privilege, unless the machine says otherwise
/// (ip_unprivileged_port_start).
constexpr std::uint16_t kFirstFreePort = 1024;
/// The RuntimeDirectory= of the service.
constexpr std::string_view kRuntimeFolder = "/run/mbgate/";

bool is_privileged(std::uint16_t port) { return port != 0 && port < kFirstFreePort; }

void add_to(std::string& list, const std::string& name) {
  list.append(list.empty() ? "" : ", ").append(name);
}

/// A link elsewhere or a pseudo-terminal may be anybody's.
bool is_of_dialout(std::string_view device) {
  return device.starts_with("/dev/") && !device.starts_with("/dev/pts/");
}

std::string text_of(const routing::ListenAddress& listen) {
  return host_and_port(listen.address.to_text(), listen.port);
}

void add_ports(const gateway::Settings& settings, std::vector<std::string>& found) {
  for (const auto& listener : settings.listeners) {
    if (is_privileged(listener.port)) {
      found.push_back(fmt::format(
          "needs port {} (listener \"{}\"): mbgated.socket{}, or the drop-in port-502.conf",
          listener.port, listener.name,
          settings.is_open_to_all(listener) ? ", for which it needs 'allow'" : ""));
    }
  }
  for (const auto& listen : settings.http.listen) {
    found.push_back(fmt::format("needs {} ([http] listen): {}", text_of(listen),
                                is_privileged(listen.port)
                                    ? "mbgated-http.socket, or the drop-in port-502.conf"
                                    : "with the drop-in socket-only.conf, mbgated-http.socket"));
  }
}

void add_lines(const gateway::Settings& settings, std::vector<std::string>& found) {
  std::string ports;
  std::string buses;
  for (const auto& bus : settings.buses) {
    if (bus.line.remote) {
      add_to(buses, fmt::format("\"{}\"", bus.name));
    } else if (is_of_dialout(bus.line.device)) {
      add_to(ports, bus.line.device);
    }
  }
  if (!ports.empty()) {
    found.push_back("needs the group dialout: " + ports);
  }
  if (!buses.empty()) {
    found.push_back(
        fmt::format("needs a network (bus {}): not with the drop-in socket-only.conf", buses));
  }
}

}  // namespace

std::string rounded(std::chrono::nanoseconds duration) {
  return to_text(std::chrono::ceil<std::chrono::milliseconds>(duration));
}

std::string check_summary(const gateway::Settings& settings) {
  std::string text = fmt::format("configuration ok: {}, {}, {}, {}",
                                 counted(settings.listeners.size(), "listener", "listeners"),
                                 counted(settings.buses.size(), "bus", "buses"),
                                 counted(settings.devices.size(), "device", "devices"),
                                 counted(settings.routes.size(), "route", "routes"));
  if (!settings.rules.empty()) {
    text += fmt::format("\n{}", rules_text(settings));
  }
  text += units_text(settings);
  text += waits_text(settings);
  for (const auto& need : needs(settings)) {
    text += fmt::format("\n{}", need);
  }
  return text;
}

std::vector<std::string> needs(const gateway::Settings& settings) {
  std::vector<std::string> found;
  add_ports(settings, found);
  add_lines(settings, found);
  if (std::ranges::any_of(settings.listeners, [](const auto& it) { return it.tls.has_value(); })) {
    found.push_back(
        fmt::format("needs {} ([gateway] signer): mbgate-signer.socket", settings.signer));
  }
  if (settings.lock_memory) {
    found.emplace_back("needs lock_memory: the drop-in realtime.conf");
  }
  const std::string& control = settings.control_socket;
  if (!control.empty() && !control.starts_with(kRuntimeFolder)) {
    found.push_back(
        fmt::format("needs [http] socket = \"{}\": ReadWritePaths= of its folder in a drop-in, or "
                    "a path below /run/mbgate",
                    control));
  }
  return found;
}

}  // namespace mbgate::config

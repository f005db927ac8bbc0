// SPDX-License-Identifier: Apache-2.0
#include "config/check_summary.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "config/sections/sections.hpp"
#include "config/toml/duration_text.hpp"
#include "gateway/limits.hpp"

namespace mbgate::config {
namespace {

std::string number_of(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

// What becomes of a request that no rule matches, or that the last one decides for all.
std::string rules_text(const gateway::Settings& settings) {
  const auto& rules = settings.rules;
  const routing::AccessRule& last = rules.back();
  const bool any_role = std::ranges::any_of(settings.listeners,
                                            [](const auto& listener) { return has_tls(listener); });
  const bool decides_all = hides(last, routing::AccessRule{.any_role = any_role});
  const std::string end = decides_all ? "the last one, " + last.title() + ", " +
                                            (last.permits ? "permits" : "denies") + " what is left"
                                      : std::string("what none of them matches is denied");
  return number_of(rules.size(), "rule", "rules") + ": " + end;
}

// What the units of a Modbus TCP server are, where one device stands for it.
std::string units_text(const gateway::Settings& settings) {
  std::string text;
  for (std::size_t at = 0; at < settings.buses.size(); ++at) {
    const auto devices = settings.devices_on(drive::BusId{static_cast<std::uint32_t>(at)});
    if (settings.buses[at].line.framing == bus::Framing::tcp && devices.size() == 1) {
      const drive::Device& device = devices.front();
      text += "\nbus " + settings.buses[at].name + ": " +
              (device.has_every_unit
                   ? "every unit is device " + device.name
                   : "device " + device.name + " is unit " + std::to_string(device.address) +
                         " alone; if all units are this device, say one_device = true");
    }
  }
  return text;
}

// How long writes may wait for their turn on each bus, and stops for the line.
std::string waits_text(const gateway::Settings& settings) {
  const auto rounded = [](bus::Duration duration) {
    return to_text(std::chrono::ceil<std::chrono::milliseconds>(duration));
  };
  std::string text;
  for (std::size_t at = 0; at < settings.buses.size(); ++at) {
    const bus::BusSettings& bus = settings.buses[at];
    const auto devices = settings.devices_on(drive::BusId{static_cast<std::uint32_t>(at)});
    const bus::Duration longest = bus::longest_transaction(bus, devices);
    text += "\nbus " + bus.name + ": writes have " + rounded(gateway::write_deadline(longest)) +
            " by default; a stop is sent " +
            (bus.line.framing == bus::Framing::tcp
                 ? "at once"
                 : "within " + rounded(bus::longest_stop_wait(bus, devices)));
  }
  return text;
}

}  // namespace

std::string check_summary(const gateway::Settings& settings) {
  std::string text =
      "configuration ok: " + number_of(settings.listeners.size(), "listener", "listeners") + ", " +
      number_of(settings.buses.size(), "bus", "buses") + ", " +
      number_of(settings.devices.size(), "device", "devices") + ", " +
      number_of(settings.routes.size(), "route", "routes");
  if (!settings.rules.empty()) {
    text.append("\n").append(rules_text(settings));
  }
  text += units_text(settings);
  text += waits_text(settings);
  for (const auto& need : needs(settings)) {
    text.append("\n").append(need);
  }
  return text;
}

namespace {

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
  const std::string address = listen.address.to_text();
  return (listen.address.is_v4() ? address : "[" + address + "]") + ":" +
         std::to_string(listen.port);
}

void add_ports(const gateway::Settings& settings, std::vector<std::string>& found) {
  for (const auto& listener : settings.listeners) {
    if (is_privileged(listener.port)) {
      found.push_back("needs port " + std::to_string(listener.port) + " (listener \"" +
                      listener.name + "\"): mbgated.socket" +
                      (settings.is_open_to_all(listener) ? ", for which it needs 'allow'" : "") +
                      ", or the drop-in port-502.conf");
    }
  }
  for (const auto& listen : settings.http.listen) {
    found.push_back("needs " + text_of(listen) + " ([http] listen): " +
                    (is_privileged(listen.port)
                         ? "mbgated-http.socket, or the drop-in port-502.conf"
                         : "with the drop-in socket-only.conf, mbgated-http.socket"));
  }
}

void add_lines(const gateway::Settings& settings, std::vector<std::string>& found) {
  std::string ports;
  std::string buses;
  for (const auto& bus : settings.buses) {
    if (bus.line.remote) {
      add_to(buses, "\"" + bus.name + "\"");
    } else if (is_of_dialout(bus.line.device)) {
      add_to(ports, bus.line.device);
    }
  }
  if (!ports.empty()) {
    found.push_back("needs the group dialout: " + ports);
  }
  if (!buses.empty()) {
    found.push_back("needs a network (bus " + buses + "): not with the drop-in socket-only.conf");
  }
}

}  // namespace

std::vector<std::string> needs(const gateway::Settings& settings) {
  std::vector<std::string> found;
  add_ports(settings, found);
  add_lines(settings, found);
  if (std::ranges::any_of(settings.listeners, [](const auto& it) { return it.tls.has_value(); })) {
    found.push_back("needs " + settings.signer + " ([gateway] signer): mbgate-signer.socket");
  }
  if (settings.lock_memory) {
    found.emplace_back("needs lock_memory: the drop-in realtime.conf");
  }
  const std::string& control = settings.control_socket;
  if (!control.empty() && !control.starts_with(kRuntimeFolder)) {
    found.push_back("needs [http] socket = \"" + control +
                    "\": ReadWritePaths= of its folder in a drop-in, or a path below /run/mbgate");
  }
  return found;
}

}  // namespace mbgate::config

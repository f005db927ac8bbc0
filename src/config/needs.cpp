// SPDX-License-Identifier: Apache-2.0
#include "config/needs.hpp"

#include <algorithm>
#include <cstdint>
#include <string_view>

namespace mbgate::config {
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

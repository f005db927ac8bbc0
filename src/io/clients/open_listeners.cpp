// SPDX-License-Identifier: Apache-2.0
#include "io/clients/open_listeners.hpp"

#include <sys/socket.h>

#include <boost/asio/ip/tcp.hpp>

#include "io/clients/listening_socket.hpp"
#include "routing/listen_address.hpp"

namespace mbgate::io {

void SystemdSockets::add(const std::string& name, int socket) {
  boost::asio::ip::tcp::endpoint at;
  auto size = static_cast<socklen_t>(at.capacity());
  if (::getsockname(socket, at.data(), &size) != 0) {
    return;  // no socket: the listener that takes it over says so
  }
  const auto address = routing::ClientAddress::parse(at.address().to_string());
  const bool is_tcp = at.data()->sa_family == AF_INET || at.data()->sa_family == AF_INET6;
  if (is_tcp && !(address && routing::is_loopback(*address))) {
    reached.insert_or_assign(name, to_text(at));
  }
}

void SystemdSockets::drop(const std::string& name) { reached.erase(name); }

std::vector<std::string> open_listeners(const gateway::Settings& settings,
                                        const SystemdSockets& sockets) {
  std::vector<std::string> found;
  for (const auto& listener : settings.listeners) {
    const auto reached = sockets.reached.find(listener.name);
    if (reached != sockets.reached.end() && settings.is_open_to_all(listener)) {
      found.push_back("listener \"" + listener.name + "\": other machines reach the socket " +
                      reached->second +
                      " from systemd: expected 'allow' with those who may connect, such as allow = "
                      "[\"192.168.10.0/24\"], or a [[rule]]");
    }
  }
  return found;
}

}  // namespace mbgate::io

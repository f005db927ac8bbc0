// SPDX-License-Identifier: Apache-2.0
#include "io/clients/listening_socket.hpp"

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <cerrno>
#include <chrono>
#include <fmt/core.h>
#include <optional>
#include <sstream>
#include <utility>

#include "io/advice.hpp"
#include "routing/client_address.hpp"

namespace mbgate::io {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// For each direction of a connection: hundreds of ADUs. The kernel's own limits are megabytes,
/// which a client that never reads, or that never stops sending, could fill on every connection.
constexpr int kSocketBuffer = 64 * 1024;

template <typename Unit>
int count_of(bus::Duration duration) {
  return static_cast<int>(std::chrono::ceil<Unit>(duration).count());
}

void set_option(tcp::acceptor& acceptor, int level, int name, int value, error_code& error) {
  if (!error && ::setsockopt(acceptor.native_handle(), level, name, &value, sizeof value) != 0) {
    error.assign(errno, boost::system::system_category());
  }
}

void set_freebind(tcp::acceptor& acceptor, bool v6, error_code& error) {
  set_option(acceptor, v6 ? IPPROTO_IPV6 : IPPROTO_IP, v6 ? IPV6_FREEBIND : IP_FREEBIND, 1, error);
}

void set_connection_options(tcp::acceptor& acceptor, const gateway::TcpSettings& tcp,
                            error_code& error) {
  set_option(acceptor, IPPROTO_TCP, TCP_NODELAY, 1, error);
  set_option(acceptor, SOL_SOCKET, SO_SNDBUF, kSocketBuffer, error);
  set_option(acceptor, SOL_SOCKET, SO_RCVBUF, kSocketBuffer, error);
  const bool keepalive = tcp.keepalive_idle > bus::Duration::zero();
  set_option(acceptor, SOL_SOCKET, SO_KEEPALIVE, keepalive ? 1 : 0, error);
  if (keepalive) {
    set_option(acceptor, IPPROTO_TCP, TCP_KEEPIDLE, count_of<seconds>(tcp.keepalive_idle), error);
    set_option(acceptor, IPPROTO_TCP, TCP_KEEPINTVL, count_of<seconds>(tcp.keepalive_interval),
               error);
    set_option(acceptor, IPPROTO_TCP, TCP_KEEPCNT, static_cast<int>(tcp.keepalive_probes), error);
  }
  set_option(acceptor, IPPROTO_TCP, TCP_USER_TIMEOUT, count_of<milliseconds>(tcp.user_timeout),
             error);
}

ListenFailure refusal(const gateway::ListenerSettings& listener, const std::string& where,
                      const std::string& why) {
  return {fmt::format("listener \"{}\": cannot listen on {}: {}", listener.name, where, why)};
}

/// Nothing if the descriptor has no such option.
std::optional<int> option_of(int socket, int level, int name) {
  int value = 0;
  socklen_t size = sizeof value;
  if (::getsockopt(socket, level, name, &value, &size) != 0) {
    return std::nullopt;
  }
  return value;
}

/// The protocol of a listening TCP socket; nothing if the descriptor is something else.
std::optional<tcp> protocol_of(int socket) {
  if (option_of(socket, SOL_SOCKET, SO_ACCEPTCONN).value_or(0) == 0) {
    return std::nullopt;
  }
  const auto family = option_of(socket, SOL_SOCKET, SO_DOMAIN);
  if (family == AF_INET) {
    return tcp::v4();
  }
  if (family == AF_INET6) {
    return tcp::v6();
  }
  return std::nullopt;
}

}  // namespace

Result<tcp::acceptor, ListenFailure> bind_listener(boost::asio::io_context& context,
                                                   const gateway::ListenerSettings& listener) {
  error_code error;
  const auto address = boost::asio::ip::make_address(listener.address, error);
  if (error) {
    return refusal(listener, listener.address, "this is not an IPv4 or IPv6 address");
  }
  const tcp::endpoint endpoint(address, listener.port);
  tcp::acceptor acceptor(context);
  acceptor.open(endpoint.protocol(), error);
  if (!error) {
    acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  }
  if (!error && address.is_v6()) {
    // Otherwise :: would take IPv4 as well, and a listener of its own for 0.0.0.0 could not be
    // bound.
    acceptor.set_option(boost::asio::ip::v6_only(true), error);
  }
  if (listener.freebind) {
    set_freebind(acceptor, address.is_v6(), error);
  }
  set_connection_options(acceptor, listener.tcp, error);
  if (!error) {
    acceptor.bind(endpoint, error);
  }
  if (!error) {
    acceptor.listen(static_cast<int>(listener.tcp.backlog), error);
  }
  if (!error) {
    acceptor.non_blocking(true, error);
  }
  if (error) {
    auto failure = refusal(listener, to_text(endpoint),
                           error.message() + listen_advice(listener.port, error.value()));
    failure.denied = is_denial(error.value());
    failure.absent = error.value() == EADDRNOTAVAIL;
    return failure;
  }
  return acceptor;
}

Result<tcp::acceptor, ListenFailure> adopt_listener(boost::asio::io_context& context,
                                                    const gateway::ListenerSettings& listener,
                                                    sys::UniqueFd socket) {
  const auto protocol = protocol_of(socket.get());
  if (!protocol) {
    return refusal(listener, "the socket from systemd", "it is not a listening TCP socket");
  }
  tcp::acceptor acceptor(context);
  error_code error;
  acceptor.assign(*protocol, socket.get(), error);
  if (!error) {
    socket.release();
    acceptor.non_blocking(true, error);
  }
  set_connection_options(acceptor, listener.tcp, error);
  if (!error) {
    acceptor.listen(static_cast<int>(listener.tcp.backlog), error);
  }
  if (error) {
    return refusal(listener, "the socket from systemd", error.message());
  }
  return acceptor;
}

bool is_bound_for(const gateway::ListenerSettings& listener, int socket) {
  error_code error;
  const auto address = boost::asio::ip::make_address(listener.address, error);
  tcp::endpoint at;
  auto size = static_cast<socklen_t>(at.capacity());
  if (error || !protocol_of(socket) || ::getsockname(socket, at.data(), &size) != 0) {
    return false;
  }
  at.resize(size);
  return at == tcp::endpoint(address, listener.port) &&
         (address.is_v4() || option_of(socket, IPPROTO_IPV6, IPV6_V6ONLY) == 1);
}

std::string to_text(const tcp::endpoint& endpoint) {
  std::ostringstream text;
  text << endpoint;
  return text.str();
}

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
      found.push_back(fmt::format(
          "listener \"{}\": other machines can reach the socket {} from systemd: expected 'allow' "
          "with the permitted clients, such as allow = [\"192.168.10.0/24\"], or a [[rule]]",
          listener.name, reached->second));
    }
  }
  return found;
}

}  // namespace mbgate::io

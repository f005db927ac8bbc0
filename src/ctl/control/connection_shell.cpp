// SPDX-License-Identifier: Apache-2.0
#include "ctl/control/connection_shell.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <boost/asio/error.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fmt/core.h>
#include <future>
#include <optional>
#include <sstream>
#include <string_view>
#include <thread>
#include <vector>

#include "base/text.hpp"

namespace mbgate::ctl {
namespace {

using boost::asio::generic::stream_protocol;
using boost::asio::ip::tcp;
using boost::system::error_code;

constexpr std::string_view kScheme = "tcp://";

bool is_tcp(const std::string& place) { return place.starts_with(kScheme); }

/// "tcp://gateway:8080", "tcp://[::1]:8080".
std::optional<HostAndPort> parse_place(std::string_view place) {
  return server_in(place.substr(kScheme.size()));
}

/// What becomes of a connection that has been begun.
error_code await_connected(ControlConnection& connection, const WaitLimit& limit) {
  pollfd asked{connection.native_handle(), POLLOUT, 0};
  while (::poll(&asked, 1, static_cast<int>(kLook.count())) <= 0) {
    if (limit.is_over()) {
      return boost::asio::error::timed_out;
    }
  }
  int failure = 0;
  socklen_t size = sizeof failure;
  ::getsockopt(connection.native_handle(), SOL_SOCKET, SO_ERROR, &failure, &size);
  return {failure, boost::system::system_category()};
}

/// A Unix socket is connected at once, or its queue is full because mbgated hangs: then the kernel
/// would wait without end.
error_code connect_to(ControlConnection& connection, const stream_protocol::endpoint& endpoint,
                      const WaitLimit& limit) {
  error_code error;
  static_cast<void>(connection.open(endpoint.protocol(), error));
  if (!error) {
    static_cast<void>(connection.native_non_blocking(true, error));
  }
  while (!error) {
    if (::connect(connection.native_handle(), endpoint.data(),
                  static_cast<socklen_t>(endpoint.size())) == 0) {
      break;
    }
    if (errno == EINPROGRESS) {
      return await_connected(connection, limit);
    }
    if (errno != EAGAIN) {
      error.assign(errno, boost::system::system_category());
    } else if (limit.is_over()) {
      error = boost::asio::error::timed_out;
    } else {
      std::this_thread::sleep_for(kLook);
    }
  }
  return error;
}

/// What a name stands for, or why that is not known.
using Endpoints = Result<std::vector<stream_protocol::endpoint>, error_code>;

Endpoints look_up(const HostAndPort& server) {
  error_code error;
  boost::asio::io_context context;
  const auto found =
      tcp::resolver(context).resolve(server.host, std::to_string(server.port), error);
  if (error) {
    return error;
  }
  std::vector<stream_protocol::endpoint> endpoints;
  for (const auto& entry : found) {
    endpoints.emplace_back(entry.endpoint());
  }
  return endpoints;
}

/// Nothing interrupts the system's search for a name, and Asio would wait for it to end. So it has
/// a thread of its own, which is left behind where the time is over: it ends with its search,
/// or with the process. An address needs none of that.
Endpoints look_up_in_time(const HostAndPort& server, const WaitLimit& limit) {
  error_code is_a_name;
  const auto address = boost::asio::ip::make_address(server.host, is_a_name);
  if (!is_a_name) {
    return std::vector<stream_protocol::endpoint>{tcp::endpoint(address, server.port)};
  }
  std::packaged_task<Endpoints()> task([server] { return look_up(server); });
  auto result = task.get_future();
  std::thread(std::move(task)).detach();
  while (result.wait_for(kLook) != std::future_status::ready) {
    if (limit.is_over()) {
      return error_code(boost::asio::error::timed_out);
    }
  }
  return result.get();
}

error_code connect_to_any(ControlConnection& connection,
                          const std::vector<stream_protocol::endpoint>& endpoints,
                          const WaitLimit& limit) {
  return try_in_turn(endpoints.size(), limit, [&](std::size_t at, const WaitLimit& share) {
    error_code ignored;
    static_cast<void>(connection.close(ignored));
    return connect_to(connection, endpoints[at], share);
  });
}

}  // namespace

std::string wrong_place(const std::string& place) {
  if (is_tcp(place)) {
    return parse_place(place) ? std::string()
                              : fmt::format(
                                    "{}: expected a host and a port, such as tcp://127.0.0.1:8080 "
                                    "or tcp://[::1]:8080",
                                    place);
  }
  return place.size() < sizeof(sockaddr_un::sun_path)
             ? std::string()
             : fmt::format("{}: the path of a socket has at most {} characters", place,
                           sizeof(sockaddr_un::sun_path) - 1);
}

error_code connect(ControlConnection& connection, const std::string& place,
                   const WaitLimit& limit) {
  const Endpoints found = is_tcp(place)
                              ? look_up_in_time(*parse_place(place), limit)
                              : Endpoints({boost::asio::local::stream_protocol::endpoint(place)});
  return found ? connect_to_any(connection, *found, limit) : found.error();
}

Result<sys::UniqueFd, std::string> connect_tcp(const HostAndPort& server,
                                               std::chrono::steady_clock::time_point deadline) {
  const WaitLimit limit{deadline, {}};
  const Endpoints found = look_up_in_time(server, limit);
  boost::asio::io_context context;
  ControlConnection connection(context);
  const error_code error = found ? connect_to_any(connection, *found, limit) : found.error();
  if (error) {
    return error == boost::system::errc::timed_out ? "no answer in time" : error.message();
  }
  return sys::UniqueFd(connection.release());
}

error_code try_in_turn(
    std::size_t count, const WaitLimit& limit,
    const std::function<error_code(std::size_t place, const WaitLimit& share)>& attempt) {
  error_code error = boost::asio::error::host_not_found;
  for (std::size_t at = 0; at < count; ++at) {
    const auto now = std::chrono::steady_clock::now();
    const auto left = static_cast<std::chrono::steady_clock::rep>(count - at);
    error = attempt(at, {now + (limit.end - now) / left, limit.give_up});
    if (!error || limit.is_over()) {
      break;
    }
  }
  return error;
}

std::string host_of(const ControlConnection& connection) {
  error_code error;
  const auto peer = connection.remote_endpoint(error);
  tcp::endpoint endpoint;
  if (error || peer.protocol().family() == AF_UNIX || peer.size() > endpoint.capacity()) {
    return "mbgated";
  }
  std::memcpy(endpoint.data(), peer.data(), peer.size());
  endpoint.resize(peer.size());
  if (endpoint.address().is_v6()) {  // without its zone, which means nothing to the other end
    auto address = endpoint.address().to_v6();
    address.scope_id(0);
    endpoint.address(address);
  }
  std::ostringstream text;
  text << endpoint;
  return text.str();
}

std::string explain(const std::string& place, const error_code& error) {
  if (is_tcp(place)) {
    return error == boost::system::errc::connection_refused
               ? fmt::format(
                     "no program listens at {}: is mbgated running, and is this one of its [http] "
                     "listen?",
                     place)
               : fmt::format("{}: {}", place, error.message());
  }
  if (error == boost::system::errc::no_such_file_or_directory) {
    return fmt::format(
        "there is no control socket at {}: is mbgated running (systemctl status mbgated)? If "
        "[http] socket names another path, give it with --control",
        place);
  }
  if (error == boost::system::errc::permission_denied) {
    return fmt::format("no permission for {}: run it as root, or as a member of its group", place);
  }
  std::error_code unknown;
  if (error == boost::system::errc::connection_refused &&
      std::filesystem::is_socket(place, unknown)) {
    return fmt::format(
        "no program listens at {} any more: mbgated has ended (journalctl -u mbgated)", place);
  }
  return fmt::format(
      "{}: {}", place,
      error == boost::system::errc::connection_refused ? "this is not a socket" : error.message());
}

}  // namespace mbgate::ctl

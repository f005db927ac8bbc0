// SPDX-License-Identifier: Apache-2.0
#include "io/denials/attempts.hpp"

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/ip/tcp.hpp>
#include <cerrno>

#include "io/unique_fd.hpp"

namespace mbgate::io {

int try_socket(int family) {
  const UniqueFd made(::socket(family, SOCK_STREAM | SOCK_CLOEXEC, 0));
  return made.is_open() ? 0 : errno;
}

int try_bind(const gateway::ListenerSettings& listener) {
  boost::system::error_code no_address;
  const auto address = boost::asio::ip::make_address(listener.address, no_address);
  if (no_address) {
    return EINVAL;
  }
  const boost::asio::ip::tcp::endpoint endpoint(address, listener.port);
  const UniqueFd made(::socket(endpoint.protocol().family(), SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (!made.is_open()) {
    return errno;
  }
  // Whether an address is there is looked at before whether the port is allowed. IPv6 must not take
  // the port of IPv4 too.
  const int on = 1;
  if (address.is_v6()) {
    ::setsockopt(made.get(), IPPROTO_IPV6, IPV6_FREEBIND, &on, sizeof on);
    ::setsockopt(made.get(), IPPROTO_IPV6, IPV6_V6ONLY, &on, sizeof on);
  } else {
    ::setsockopt(made.get(), IPPROTO_IP, IP_FREEBIND, &on, sizeof on);
  }
  return ::bind(made.get(), endpoint.data(), static_cast<socklen_t>(endpoint.size())) == 0 ? 0
                                                                                           : errno;
}

int try_folder(const std::string& folder) {
  return ::access(folder.c_str(), W_OK | X_OK) == 0 ? 0 : errno;
}

}  // namespace mbgate::io

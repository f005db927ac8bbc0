// SPDX-License-Identifier: Apache-2.0
#include "io/lines/host_addresses.hpp"

#include <netdb.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <system_error>

#include "base/text.hpp"

namespace mbgate::io {
namespace {

using boost::asio::ip::tcp;

struct FreeAddresses {
  void operator()(addrinfo* first) const { ::freeaddrinfo(first); }
};

}  // namespace

std::string to_text(const bus::Endpoint& remote) {
  return "tcp://" + host_and_port(remote.host, remote.port);
}

std::optional<tcp::endpoint> numeric_endpoint(const bus::Endpoint& remote) {
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(remote.host, error);
  return error ? std::nullopt : std::optional(tcp::endpoint(address, remote.port));
}

Result<HostAddresses, std::string> resolve(const bus::Endpoint& remote) {
  addrinfo wanted{};
  wanted.ai_family = AF_UNSPEC;
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* first = nullptr;
  const int failure = ::getaddrinfo(remote.host.c_str(), nullptr, &wanted, &first);
  if (failure != 0) {
    return failure == EAI_SYSTEM ? std::generic_category().message(errno)
                                 : std::string(::gai_strerror(failure));
  }
  const std::unique_ptr<addrinfo, FreeAddresses> owner(first);
  HostAddresses addresses;
  for (const addrinfo* each = first; each != nullptr && addresses.size() < kMaxHostAddresses;
       each = each->ai_next) {
    tcp::endpoint endpoint;
    if (each->ai_addrlen <= endpoint.capacity()) {
      std::memcpy(endpoint.data(), each->ai_addr, each->ai_addrlen);
      endpoint.resize(each->ai_addrlen);
      endpoint.port(remote.port);
      if (std::ranges::find(addresses, endpoint) == addresses.end()) {
        addresses.push_back(endpoint);
      }
    }
  }
  return addresses;
}

}  // namespace mbgate::io

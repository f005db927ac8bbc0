// SPDX-License-Identifier: Apache-2.0
#include "sim/program/tcp_port.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

#include "base/text.hpp"

namespace mbgate::sim {
namespace {

constexpr int kBacklog = 16;
constexpr int kOn = 1;

sockaddr_in socket_address(const ListenAddress& address) {
  sockaddr_in raw{};
  raw.sin_family = AF_INET;
  raw.sin_port = htons(address.port);
  ::inet_pton(AF_INET, address.host.c_str(), &raw.sin_addr);
  return raw;
}

// Right after a restart the port still belongs to connections of before.
bool listen_at(int socket, const ListenAddress& address) {
  const sockaddr_in raw = socket_address(address);
  return socket >= 0 && ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &kOn, sizeof kOn) == 0 &&
         ::bind(socket, reinterpret_cast<const sockaddr*>(&raw), sizeof raw) == 0 &&
         ::listen(socket, kBacklog) == 0;
}

std::uint16_t port_of(int socket) {
  sockaddr_in raw{};
  socklen_t size = sizeof raw;
  ::getsockname(socket, reinterpret_cast<sockaddr*>(&raw), &size);
  return ntohs(raw.sin_port);
}

/// False if the other side has closed.
bool read_all(int socket, std::vector<std::uint8_t>& bytes) {
  std::array<std::uint8_t, 4096> part{};
  for (;;) {
    const ssize_t size = ::recv(socket, part.data(), part.size(), 0);
    if (size <= 0) {
      return size < 0 && (errno == EAGAIN || errno == EINTR);
    }
    bytes.insert(bytes.end(), part.begin(), part.begin() + size);
  }
}

// What is not taken at once is lost, and the stream with it.
void send_or_shut(int socket, modbus::Bytes bytes) {
  const ssize_t size = ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  if (size != static_cast<ssize_t>(bytes.size())) {
    ::shutdown(socket, SHUT_RDWR);
  }
}

}  // namespace

Result<TcpPort, std::string> TcpPort::open(const ListenAddress& address,
                                           std::size_t most_connections) {
  sys::UniqueFd listener(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!listen_at(listener.get(), address)) {
    return "cannot listen on " + address.text() + ": " + std::generic_category().message(errno);
  }
  const ListenAddress bound{address.host, port_of(listener.get())};
  return TcpPort(std::move(listener), bound, most_connections);
}

TcpPort::TcpPort(sys::UniqueFd listener, ListenAddress address, std::size_t most_connections)
    : listener_(std::move(listener)),
      address_(std::move(address)),
      most_connections_(most_connections) {}

std::vector<int> TcpPort::descriptors() const {
  std::vector<int> all{listener_.get()};
  for (const auto& [connection, socket] : connections_) {
    all.push_back(socket.get());
  }
  return all;
}

// Who has gone is noticed before somebody new is let in.
std::vector<TcpPort::Received> TcpPort::receive() {
  std::vector<Received> all;
  const auto read_from = [&all](ConnectionId connection, const sys::UniqueFd& socket) {
    Received received{connection, {}, false};
    received.closed = !read_all(socket.get(), received.bytes);
    if (received.closed || !received.bytes.empty()) {
      all.push_back(std::move(received));
    }
  };
  for (const auto& [connection, socket] : connections_) {
    read_from(connection, socket);
  }
  for (const Received& received : all) {
    if (received.closed) {
      close(received.connection);
    }
  }
  accept();
  return all;
}

void TcpPort::accept() {
  for (;;) {
    sys::UniqueFd socket(
        ::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (socket.get() < 0) {
      return;
    }
    if (connections_.size() < most_connections_) {
      ::setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &kOn, sizeof kOn);
      connections_.emplace(next_++, std::move(socket));
    }
  }
}

void TcpPort::send(ConnectionId connection, modbus::Bytes bytes) {
  const auto found = connections_.find(connection);
  if (found != connections_.end()) {
    send_or_shut(found->second.get(), bytes);
  }
}

void TcpPort::send(modbus::Bytes bytes) {
  for (const auto& [connection, socket] : connections_) {
    send_or_shut(socket.get(), bytes);
  }
}

std::optional<ListenAddress> ListenAddress::parse(std::string_view text) {
  const auto place = host_and_port(text);
  in_addr unused{};
  const bool is_valid = place && ::inet_pton(AF_INET, place->host.c_str(), &unused) == 1;
  return is_valid ? std::optional(ListenAddress{place->host, place->port}) : std::nullopt;
}

}  // namespace mbgate::sim

// SPDX-License-Identifier: Apache-2.0
#include "integration/tcp_client.hpp"

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdio>
#include <stdexcept>
#include <utility>

namespace mbgate::test {

ByteString bytes_of(std::string_view hexadecimal) {
  ByteString bytes;
  int high = -1;
  for (const char character : hexadecimal) {
    const auto digit = std::string_view("0123456789ABCDEF").find(character);
    if (digit == std::string_view::npos) {
      continue;
    }
    if (high < 0) {
      high = static_cast<int>(digit);
    } else {
      bytes.push_back(static_cast<std::uint8_t>(high * 16 + static_cast<int>(digit)));
      high = -1;
    }
  }
  return bytes;
}

std::string text_of(const ByteString& bytes) {
  std::string text;
  for (const auto byte : bytes) {
    char digits[4];
    std::snprintf(digits, sizeof digits, text.empty() ? "%02X" : " %02X", unsigned{byte});
    text += digits;
  }
  return text;
}

TcpClient::TcpClient(std::uint16_t port, const char* source)
    : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in own{};
  own.sin_family = AF_INET;
  inet_pton(AF_INET, source, &own.sin_addr);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int on = 1;
  setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  if (bind(socket_, reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0 ||
      connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    close(socket_);
    throw std::runtime_error("cannot connect to port " + std::to_string(port));
  }
}

TcpClient::TcpClient(TcpClient&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)),
      closed_(other.closed_),
      buffer_(std::move(other.buffer_)) {}

TcpClient::~TcpClient() {
  if (socket_ >= 0) {
    close(socket_);
  }
}

bool TcpClient::send(const ByteString& bytes) const {
  std::size_t sent = 0;
  while (sent < bytes.size()) {
    const ssize_t count = ::send(socket_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (count <= 0) {
      return false;
    }
    sent += static_cast<std::size_t>(count);
  }
  return true;
}

void TcpClient::half_close() const { shutdown(socket_, SHUT_WR); }

bool TcpClient::read_more(int limit_ms) {
  pollfd watched{socket_, POLLIN, 0};
  if (closed_ || poll(&watched, 1, limit_ms) <= 0) {
    return false;
  }
  std::uint8_t piece[4096];
  const ssize_t count = recv(socket_, piece, sizeof piece, 0);
  if (count <= 0) {
    closed_ = true;
    return false;
  }
  buffer_.insert(buffer_.end(), piece, piece + count);
  return true;
}

std::optional<ByteString> TcpClient::receive(int limit_ms) {
  for (;;) {
    if (buffer_.size() >= 6) {
      const std::size_t size = 6U + (static_cast<std::size_t>(buffer_[4]) << 8U) + buffer_[5];
      if (buffer_.size() >= size) {
        const auto end = buffer_.begin() + static_cast<std::ptrdiff_t>(size);
        ByteString adu(buffer_.begin(), end);
        buffer_.erase(buffer_.begin(), end);
        return adu;
      }
    }
    if (!read_more(limit_ms)) {
      return std::nullopt;
    }
  }
}

bool TcpClient::is_closed(int limit_ms) {
  while (read_more(limit_ms)) {
  }
  return closed_;
}

}  // namespace mbgate::test

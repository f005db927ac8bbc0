// SPDX-License-Identifier: Apache-2.0
// A plain socket that speaks bytes: for what no well-behaved library would send.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace mbgate::test {

using ByteString = std::vector<std::uint8_t>;

/// The bytes of hexadecimal digits; everything else in the text is decoration.
ByteString bytes_of(std::string_view hexadecimal);
/// "00 01 0A".
std::string text_of(const ByteString& bytes);

class TcpClient {
 public:
  /// Connects to loopback, from an address of it; throws if it cannot.
  explicit TcpClient(std::uint16_t port, const char* source = "127.0.0.1");
  ~TcpClient();
  TcpClient(TcpClient&& other) noexcept;
  TcpClient& operator=(TcpClient&&) = delete;
  TcpClient(const TcpClient&) = delete;
  TcpClient& operator=(const TcpClient&) = delete;

  /// False once the peer has closed.
  bool send(const ByteString& bytes) const;
  void half_close() const;
  /// The next whole ADU; nothing if the peer closed or none came within the limit.
  std::optional<ByteString> receive(int limit_ms = 60'000);
  /// Has the peer closed the connection within the limit? Throws answers away.
  bool is_closed(int limit_ms = 60'000);
  [[nodiscard]] int descriptor() const { return socket_; }

 private:
  bool read_more(int limit_ms);

  int socket_ = -1;
  bool closed_ = false;
  ByteString buffer_;
};

}  // namespace mbgate::test

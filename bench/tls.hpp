// SPDX-License-Identifier: Apache-2.0
// Clients over TLS: OpenSSL on the sockets of the load, without Modbus' or mbgate's own code for
// it.
#pragma once

#include <openssl/ssl.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "sys/unique_fd.hpp"

namespace mbgate::bench {

/// In PEM. The authority's certificate is the server's too.
struct TlsFiles {
  std::filesystem::path certificate;
  std::filesystem::path key;
  std::filesystem::path authorities;
};

struct FreeSession {
  void operator()(SSL* session) const { ::SSL_free(session); }
};
using TlsSession = std::unique_ptr<SSL, FreeSession>;

/// What all connections of a process have in common.
class TlsClients {
 public:
  /// Throws std::runtime_error.
  explicit TlsClients(const TlsFiles& files);

  /// A whole handshake on a socket that is connected and blocks. Throws std::runtime_error.
  [[nodiscard]] TlsSession shake_hands(int socket) const;

 private:
  struct FreeContext {
    void operator()(SSL_CTX* context) const { ::SSL_CTX_free(context); }
  };
  std::unique_ptr<SSL_CTX, FreeContext> context_;
};

/// A connection to a gateway, with or without TLS. Nothing is read or written before there is.
class Stream {
 public:
  Stream() = default;
  Stream(sys::UniqueFd socket, const TlsClients* tls);

  [[nodiscard]] bool is_open() const { return socket_.get() >= 0; }
  [[nodiscard]] int descriptor() const { return socket_.get(); }
  void close();

  /// Sends all of it, or says that the connection is lost.
  [[nodiscard]] bool send(std::span<const std::uint8_t> bytes);
  /// Are there bytes that the socket has given away already?
  [[nodiscard]] bool has_pending() const { return session_ && ::SSL_pending(session_.get()) > 0; }
  /// How many bytes there were: -1 none yet, 0 the connection is lost. There may be more.
  [[nodiscard]] std::ptrdiff_t receive(std::span<std::uint8_t> bytes);

 private:
  sys::UniqueFd socket_{};
  TlsSession session_{};
};

/// Shakes hands with a port of 127.0.0.1 again and again, without a word in between, until it is
/// killed; counts in `done`. It takes only what processors have left, since it stands for another
/// computer. Throws std::runtime_error if a handshake fails.
void run_handshakes(const TlsFiles& files, std::uint16_t port, std::uint64_t& done);

}  // namespace mbgate::bench

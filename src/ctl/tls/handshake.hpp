// SPDX-License-Identifier: Apache-2.0
// From a host and a port to a connection over TLS 1.2 or 1.3 with a server that is known: mutual
// authentication, as Modbus/TCP Security has it.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "ctl/request/command.hpp"
#include "modbus/result.hpp"
#include "sys/openssl.hpp"
#include "sys/tls_stream.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::ctl {

using Deadline = std::chrono::steady_clock::time_point;

/// A socket for whoever cannot speak TLS: what is written into it goes to the server over TLS, and
/// what the server says comes out of it. A thread carries the bytes from one to the other.
class TlsTunnel {
 public:
  /// Within `timeout`, the TCP connection and the handshake together. The error says why, in words
  /// that follow "cannot connect to HOST:PORT: ".
  static Result<std::unique_ptr<TlsTunnel>, std::string> open(const std::string& host,
                                                              std::uint16_t port,
                                                              std::chrono::nanoseconds timeout,
                                                              const TlsIdentity& identity);
  /// Says goodbye to the server. The other end must have been closed.
  ~TlsTunnel();
  TlsTunnel(const TlsTunnel&) = delete;
  TlsTunnel& operator=(const TlsTunnel&) = delete;

  /// The socket, which belongs to the caller from then on.
  [[nodiscard]] int take_socket() { return theirs_.release(); }
  /// Why the server is gone; empty as long as it is not known to be, or where we have ended it.
  [[nodiscard]] std::string why_ended() const;

 private:
  TlsTunnel(sys::UniqueFd socket, sys::SslHandle session);
  /// Shakes hands; why not, or nothing, and bytes are carried from then on.
  std::optional<std::string> start(Deadline deadline);
  void carry(sys::TlsPump& pump);

  sys::UniqueFd socket_;
  sys::TlsStream stream_;
  sys::UniqueFd ours_;
  sys::UniqueFd theirs_;
  std::string why_ended_;  ///< written before `has_ended_`
  std::atomic<bool> has_ended_{false};
  std::thread thread_;
};

/// The role in the first certificate of a file, as a gateway reads it: "operator" in quotes, or
/// "none: ..."; empty if the file has no certificate.
std::string role_in_file(const std::filesystem::path& file);

}  // namespace mbgate::ctl

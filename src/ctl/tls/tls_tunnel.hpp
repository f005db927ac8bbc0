// SPDX-License-Identifier: Apache-2.0
// A socket for whoever cannot speak TLS: what is written into it goes to the server over TLS, and
// what the server says comes out of it. A thread carries the bytes from one to the other.
#pragma once

#include <atomic>
#include <string>
#include <thread>

#include "ctl/tls/handshake.hpp"

namespace mbgate::ctl {

class TlsTunnel {
 public:
  explicit TlsTunnel(TlsConnection connection);
  /// Says goodbye to the server. The other end must have been closed.
  ~TlsTunnel();
  TlsTunnel(const TlsTunnel&) = delete;
  TlsTunnel& operator=(const TlsTunnel&) = delete;

  /// The socket, which belongs to the caller from then on.
  [[nodiscard]] int take_socket() { return theirs_.release(); }

  /// Why the server is gone; empty as long as it is not known to be, or where we have ended it.
  [[nodiscard]] std::string why_ended() const;

 private:
  void carry();

  TlsConnection connection_;
  sys::UniqueFd ours_;
  sys::UniqueFd theirs_;
  std::string why_ended_;  ///< written before `has_ended_`
  std::atomic<bool> has_ended_{false};
  std::thread thread_;
};

}  // namespace mbgate::ctl

// SPDX-License-Identifier: Apache-2.0
// The socket to which mbgated connects: a few connections, one request at a time, no thread.
// Everything is bounded: a connection too many is closed at once, and so is one that does not read
// its answer.
#pragma once

#include <csignal>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "signer/key_file.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::signer {

class Door {
 public:
  /// Connections at a time. mbgated has one for each key of its listeners, for a moment twice as
  /// many, and one more for each line that is shaking hands.
  static constexpr std::size_t kMostConnections = 32;

  /// The socket, one of SOCK_SEQPACKET that listens, stays the caller's.
  Door(int listening, KeyStore store) : listening_(listening), store_(std::move(store)) {}

  /// Serves until a signal has come. `mask`: the signals that are not blocked while it waits.
  void run(const sigset_t& mask, const volatile std::sig_atomic_t& ended);

 private:
  struct Connection {
    sys::UniqueFd socket;
    std::optional<KeyFile> key;
  };

  void accept();
  /// False: this connection has ended.
  bool answer(Connection& connection) const;
  [[nodiscard]] Octets answer_to(Connection& connection, std::span<const std::uint8_t> said) const;

  int listening_;
  KeyStore store_;
  std::vector<Connection> connections_;
};

}  // namespace mbgate::signer

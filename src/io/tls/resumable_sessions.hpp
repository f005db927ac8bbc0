// SPDX-License-Identifier: Apache-2.0
// TLS sessions that their clients may resume (MB-TCP-Security v36, R-42). They are kept only here:
// a client gets a number, no ticket. The oldest goes first.
#pragma once

#include <cstddef>
#include <list>
#include <string>
#include <string_view>
#include <unordered_map>

#include "io/tls/openssl_handles.hpp"

namespace mbgate::io {

class ResumableSessions {
 public:
  struct Kept {
    std::string id;
    SessionHandle session;
    ChainHandle chain;  ///< what the client has shown beside its own certificate
  };

  explicit ResumableSessions(std::size_t most) : most_(most) {}

  void keep(SessionHandle session, ChainHandle chain);
  /// nullptr if it is not known (any more).
  [[nodiscard]] Kept* find(std::string_view id);
  void forget(std::string_view id);
  [[nodiscard]] std::size_t size() const { return kept_.size(); }

 private:
  std::size_t most_;
  std::list<Kept> kept_;  ///< the oldest first
  std::unordered_map<std::string, std::list<Kept>::iterator> by_id_;
};

/// The number of a session.
std::string id_of(const SSL_SESSION* session);

}  // namespace mbgate::io

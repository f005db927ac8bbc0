// SPDX-License-Identifier: Apache-2.0
// What the thread of the machine and that of TLS tell each other about clients.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "gateway/settings.hpp"
#include "io/tls/tls_context.hpp"
#include "routing/client_role.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::io {

/// By the names of their [[tls]].
using TlsContexts = std::map<std::string, std::shared_ptr<TlsContext>>;
/// By the listeners that use them now.
using ListenerContexts = std::map<gateway::ListenerId, std::shared_ptr<TlsContext>>;

/// Where a client has connected, and from where; and the number of its handshake.
struct TlsPlace {
  gateway::ListenerId listener{};
  routing::ClientAddress address;
  std::uint64_t handshake = 0;
};

/// A client that has connected.
struct TlsCandidate {
  TlsPlace place;
  sys::UniqueFd socket;
  boost::asio::ip::tcp protocol = boost::asio::ip::tcp::v4();
  std::shared_ptr<TlsContext> context;
  gateway::HandshakeSettings limits;
};

/// A client that has shaken hands.
struct TlsArrival {
  TlsPlace place;
  sys::UniqueFd socket;  ///< the machine's end of the pair
  routing::ClientRole role;
  std::size_t bytes_waiting =
      0;  ///< what is to be read from it is as old as the process's last stop
};

/// Called on the thread of the machine.
class TlsEvents {
 public:
  virtual ~TlsEvents() = default;
  /// It has brought its ClientHello; tls_arrived() or tls_refused() follows.
  virtual void tls_greeted(const TlsPlace& /*place*/) {}
  virtual void tls_arrived(TlsArrival arrival) = 0;
  /// There was no handshake.
  virtual void tls_refused(const TlsPlace& place, const std::string& why) = 0;
  /// A client that had arrived was ended. The machine sees that its socket has gone.
  virtual void tls_ended(const TlsPlace& place, const std::string& why) = 0;
  /// The thread of TLS has not run for so long: what it hands on until tls_drained() is old.
  virtual void tls_behind(std::chrono::milliseconds missed) = 0;
  virtual void tls_drained() = 0;
};

}  // namespace mbgate::io

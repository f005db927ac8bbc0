// SPDX-License-Identifier: Apache-2.0
// The settings of a TLS server, and its checks of clients (MB-TCP-Security v36): TLS 1.2 and 1.3,
// one cipher suite each for RSA and EC, a certificate of both ends, chains and revocations checked.
// Made on any thread and then used on one; a reload makes another one.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "bus/instant.hpp"
#include "gateway/settings.hpp"
#include "modbus/result.hpp"
#include "routing/client_address.hpp"
#include "sys/openssl.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::io {

/// Why there is no context. `may_come`: another process is not there yet.
struct TlsFailure {
  std::string why;
  bool may_come = false;
};

/// When something of it ends.
struct TlsDates {
  std::chrono::system_clock::time_point certificate_ends;
  std::optional<std::chrono::system_clock::time_point> crl_ends{};  ///< none: there is no list
};

/// What of the files is in use, in words (io/tls/fingerprint).
struct TlsContents {
  std::string certificate;
  std::string authorities;
  std::string lists;  ///< of revoked certificates
};

class TlsContext {
 public:
  /// Reads the files, and asks mbgate-signer at this socket for the key; an empty socket: all but
  /// the key is looked at, and the context is of no use.
  static Result<std::shared_ptr<TlsContext>, TlsFailure> make(const gateway::TlsSettings& settings,
                                                              const std::string& signer);
  TlsContext(const TlsContext&) = delete;
  TlsContext& operator=(const TlsContext&) = delete;
  ~TlsContext() = default;

  /// For one client. What it has of the private key goes with SSL_certs_clear().
  [[nodiscard]] sys::SslHandle new_ssl() const;
  /// No client comes any more. Handshakes that are under way go on.
  void drop_key() { key_.reset(); }
  /// Why this certificate is not accepted now, by chain, dates and revocations; nothing: it is.
  /// `chain` may be nullptr.
  std::optional<std::string> objection(X509* certificate, STACK_OF(X509) * chain) const;
  [[nodiscard]] const TlsDates& dates() const { return dates_; }
  [[nodiscard]] const TlsContents& contents() const { return contents_; }

 private:
  TlsContext();

  std::optional<std::string> take_certificate(const std::string& path);
  std::optional<std::string> take_trust(const gateway::TlsSettings& settings);
  std::optional<TlsFailure> take_key(const std::string& signer, const std::string& key);

  sys::ContextHandle context_;
  sys::KeyHandle key_;
  TlsDates dates_{};
  TlsContents contents_{};
};

/// The role in this certificate, and its name.
routing::ClientRole role_in(const X509* certificate);

// What the thread of the machine and that of TLS tell each other about clients.

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
  /// What it has sent already came no earlier; Instant::min(): before the thread of TLS was
  /// stopped.
  bus::Instant since = bus::Instant::min();
};

/// Called on the thread of the machine.
class TlsEvents {
 public:
  virtual ~TlsEvents() = default;
  /// It has brought its ClientHello; tls_arrived() or tls_refused() follows.
  virtual void tls_greeted(const TlsPlace& /*place*/) {}
  virtual void tls_arrived(TlsArrival arrival) = 0;
  /// There was no handshake; or a client that had arrived was ended, and the machine sees that its
  /// socket has gone.
  virtual void tls_refused(const TlsPlace& place, const std::string& why) = 0;
  /// The thread of TLS has not run for so long: what it hands on until tls_drained() is old.
  virtual void tls_behind(std::chrono::milliseconds missed) = 0;
  virtual void tls_drained() = 0;
};

}  // namespace mbgate::io

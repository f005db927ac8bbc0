// SPDX-License-Identifier: Apache-2.0
// What a server of TLS is, and whom it lets in (MB-TCP-Security v36): TLS 1.2 and 1.3, one cipher
// suite each for RSA and EC, a certificate of both ends, chains and revocations checked. Made on
// any thread and then used on one; a reload makes another one.
#pragma once

#include <chrono>
#include <cstddef>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "gateway/settings.hpp"
#include "modbus/result.hpp"
#include "routing/client_role.hpp"
#include "sys/openssl.hpp"

namespace mbgate::io {

// TLS sessions that their clients may resume (MB-TCP-Security v36, R-42). They are kept only here:
// a client gets a number, no ticket. The oldest goes first.

class ResumableSessions {
 public:
  struct Kept {
    std::string id;
    sys::SessionHandle session;
    sys::ChainHandle chain;  ///< what the client has shown beside its own certificate
  };

  explicit ResumableSessions(std::size_t most) : most_(most) {}

  void keep(sys::SessionHandle session, sys::ChainHandle chain);
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
  ~TlsContext();

  /// For one client.
  [[nodiscard]] sys::SslHandle new_ssl() const { return sys::SslHandle(SSL_new(context_.get())); }
  /// Why this certificate is not accepted now, by chain, dates and revocations; nothing: it is.
  /// `chain` may be nullptr.
  std::optional<std::string> objection(X509* certificate, STACK_OF(X509) * chain) const;
  [[nodiscard]] const TlsDates& dates() const { return dates_; }
  [[nodiscard]] const TlsContents& contents() const { return contents_; }
  /// Its session must not be taken up again.
  void forget_session_of(const SSL* ssl);

 private:
  TlsContext();

  std::optional<std::string> take_certificate(const std::string& path);
  std::optional<std::string> take_trust(const gateway::TlsSettings& settings);
  std::optional<TlsFailure> take_key(const std::string& signer, const std::string& key);
  void keep_sessions();
  static TlsContext& of(const SSL_CTX* context);
  static int session_made(SSL* ssl, SSL_SESSION* session);
  static SSL_SESSION* session_wanted(SSL* ssl, const unsigned char* id, int size, int* copy);
  static void session_ended(SSL_CTX* context, SSL_SESSION* session);

  sys::ContextHandle context_;
  ResumableSessions sessions_;
  TlsDates dates_{};
  TlsContents contents_{};
};

/// The role in this certificate, and its name.
routing::ClientRole role_in(const X509* certificate);

}  // namespace mbgate::io

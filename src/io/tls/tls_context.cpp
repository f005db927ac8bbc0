// SPDX-License-Identifier: Apache-2.0
#include "io/tls/tls_context.hpp"

#include <openssl/x509_vfy.h>

#include <algorithm>
#include <ctime>
#include <fmt/core.h>
#include <utility>

#include "io/tls/fingerprint.hpp"
#include "io/tls/pem_files.hpp"
#include "io/tls/signer_client.hpp"
#include "routing/client_address.hpp"

namespace mbgate::io {
namespace {

using std::chrono::system_clock;

/// TLS_RSA_WITH_NULL_SHA256 is not offered: what drives do is not for everybody.
constexpr const char* kCiphers = "ECDHE-ECDSA-AES128-GCM-SHA256:ECDHE-RSA-AES128-GCM-SHA256";
constexpr const char* kCiphers13 = "TLS_AES_128_GCM_SHA256";
/// P-256 first.
constexpr const char* kGroups = "P-256:X25519:P-384";
/// No SHA-1 and no MD5.
constexpr const char* kSignatures =
    "ECDSA+SHA256:RSA-PSS+SHA256:rsa_pss_pss_sha256:RSA+SHA256:ECDSA+SHA384:RSA-PSS+SHA384:"
    "RSA+SHA384:ECDSA+SHA512:RSA-PSS+SHA512:RSA+SHA512";
constexpr long kMostSessions = 1024;
constexpr long kSessionSeconds = 3600;
constexpr int kDeepestChain = 8;

/// The clock has nanoseconds and ends in 2262; a certificate without an end says 9999 (RFC 5280,
/// 4.1.2.5).
system_clock::time_point time_of(const ASN1_TIME* time) {
  using Time = system_clock::time_point;
  std::tm parts{};
  return ASN1_TIME_to_tm(time, &parts) == 1
             ? system_clock::from_time_t(std::clamp(::timegm(&parts),
                                                    system_clock::to_time_t(Time::min()),
                                                    system_clock::to_time_t(Time::max())))
             : Time::max();
}

struct FreeOctets {
  void operator()(unsigned char* octets) const { OPENSSL_free(octets); }
};

/// Of several, the last one: the most specific (RFC 4514, 2.1 begins with it). A name with control
/// characters, which would not be shown as it is, counts as none.
std::string common_name_in(const X509* certificate) {
  const X509_NAME* const subject = X509_get_subject_name(certificate);
  int last = -1;
  for (int at = -1; (at = X509_NAME_get_index_by_NID(subject, NID_commonName, at)) >= 0;) {
    last = at;
  }
  if (last < 0) {
    return {};
  }
  unsigned char* text = nullptr;
  const int size =
      ASN1_STRING_to_UTF8(&text, X509_NAME_ENTRY_get_data(X509_NAME_get_entry(subject, last)));
  const std::unique_ptr<unsigned char, FreeOctets> owner(text);
  const std::string name = size < 0 ? std::string() : std::string(text, text + size);
  const auto is_control = [](char c) { return (c >= 0 && c < ' ') || c == '\x7F'; };
  return std::ranges::any_of(name, is_control) ? std::string() : name;
}

/// A session that is resumed is judged once more only after its handshake (TlsFront): it ends with
/// the certificates that the client has shown, so that the handshake itself says what is wrong.
int limit_session(SSL* ssl, SSL_SESSION* session) {
  long left = SSL_SESSION_get_timeout(session);
  const auto shorten = [&](const X509* certificate) {
    const auto ends = system_clock::to_time_t(time_of(X509_get0_notAfter(certificate)));
    const auto lasts = ends - 1 - SSL_SESSION_get_time(session);
    left = static_cast<long>(std::clamp<std::time_t>(lasts, 0, left));
  };
  shorten(SSL_get0_peer_certificate(ssl));
  const STACK_OF(X509)* const chain = SSL_get_peer_cert_chain(ssl);
  for (int at = 0; at < sk_X509_num(chain); ++at) {
    shorten(sk_X509_value(chain, at));
  }
  SSL_SESSION_set_timeout(session, left);
  return 0;  // the reference is not ours
}

/// Clients may resume their sessions (MB-TCP-Security v36, R-42), which OpenSSL keeps, and forgets
/// after a fatal alert. A client gets a number, no ticket.
void keep_sessions(SSL_CTX& context) {
  constexpr unsigned char kName[] = "mbgate";
  SSL_CTX_set_session_id_context(&context, kName, sizeof kName - 1);
  SSL_CTX_set_session_cache_mode(&context, SSL_SESS_CACHE_SERVER);
  SSL_CTX_sess_set_cache_size(&context, kMostSessions);
  SSL_CTX_set_timeout(&context, kSessionSeconds);
  SSL_CTX_set_num_tickets(&context, 1);  // TLS 1.3: the number of the session, and no more
  SSL_CTX_sess_set_new_cb(&context, limit_session);
}

}  // namespace

TlsContext::TlsContext() : context_(SSL_CTX_new(TLS_server_method())) {
  SSL_CTX* const context = context_.get();
  SSL_CTX_set_min_proto_version(context, TLS1_2_VERSION);
  SSL_CTX_set_max_proto_version(context, TLS1_3_VERSION);
  SSL_CTX_set_cipher_list(context, kCiphers);
  SSL_CTX_set_ciphersuites(context, kCiphers13);
  SSL_CTX_set1_groups_list(context, kGroups);
  SSL_CTX_set1_sigalgs_list(context, kSignatures);
  // A FIN without close_notify is what a program that was ended sends. A request that it cuts is
  // not carried out anyway.
  SSL_CTX_set_options(context, SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_TICKET | SSL_OP_NO_COMPRESSION |
                                   SSL_OP_CIPHER_SERVER_PREFERENCE | SSL_OP_IGNORE_UNEXPECTED_EOF);
  SSL_CTX_set_mode(context, SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER |
                                SSL_MODE_RELEASE_BUFFERS);
  SSL_CTX_set_verify(context, SSL_VERIFY_PEER | SSL_VERIFY_FAIL_IF_NO_PEER_CERT,
                     accept_expired_list);
  SSL_CTX_set_verify_depth(context, kDeepestChain);
  keep_sessions(*context);
}

Result<std::shared_ptr<TlsContext>, TlsFailure> TlsContext::make(
    const gateway::TlsSettings& settings, const std::string& signer) {
  std::shared_ptr<TlsContext> made(new TlsContext());
  auto wrong = made->take_certificate(settings.certificate);
  if (!wrong) {
    wrong = made->take_trust(settings);
  }
  if (wrong) {
    return TlsFailure{*std::move(wrong)};
  }
  if (!signer.empty()) {
    if (auto failure = made->take_key(signer, settings.key)) {
      return *std::move(failure);
    }
  }
  return made;
}

std::optional<std::string> TlsContext::take_certificate(const std::string& path) {
  auto wrong = use_certificate(*context_, path);
  if (!wrong) {
    const X509* const own = SSL_CTX_get0_certificate(context_.get());
    dates_.certificate_ends = time_of(X509_get0_notAfter(own));
    contents_.certificate = fingerprint(*own);
  }
  return wrong;
}

std::optional<std::string> TlsContext::take_trust(const gateway::TlsSettings& settings) {
  const auto trusted = use_authorities(*context_, settings.authorities, settings.crl);
  if (!trusted) {
    return trusted.error();
  }
  for (const auto& authority : trusted->authorities) {
    if (SSL_CTX_add_client_CA(context_.get(), authority.get()) != 1) {
      return fmt::format("{}: {}", settings.authorities, sys::take_openssl_error());
    }
  }
  contents_.authorities = fingerprints(trusted->authorities);
  contents_.lists = lists_text(trusted->lists);
  for (const auto& list : trusted->lists) {
    if (const ASN1_TIME* const ends = X509_CRL_get0_nextUpdate(list.get())) {
      const auto time = time_of(ends);
      dates_.crl_ends = dates_.crl_ends ? std::min(*dates_.crl_ends, time) : time;
    }
  }
  return std::nullopt;
}

std::optional<TlsFailure> TlsContext::take_key(const std::string& signer, const std::string& key) {
  auto client = SignerClient::open(signer, key);
  if (!client) {
    return TlsFailure{client.error().why, client.error().absent};
  }
  key_ = remote_key(*std::move(client));
  if (!key_) {
    return TlsFailure{key + ": expected a key of RSA or EC"};
  }
  if (X509_check_private_key(SSL_CTX_get0_certificate(context_.get()), key_.get()) != 1) {
    return TlsFailure{fmt::format("{}: it is not the key of the certificate ({})", key,
                                  sys::take_openssl_error())};
  }
  return std::nullopt;
}

// The key is that of a handshake, not of the context, which all its clients keep as long as they
// are connected: with the key goes the connection to the signer.
sys::SslHandle TlsContext::new_ssl() const {
  sys::SslHandle ssl(SSL_new(context_.get()));
  if (ssl && key_) {
    SSL_use_PrivateKey(ssl.get(), key_.get());
  }
  return ssl;
}

std::optional<std::string> TlsContext::objection(X509* certificate, STACK_OF(X509) * chain) const {
  const std::unique_ptr<X509_STORE_CTX, sys::FreeWith<X509_STORE_CTX_free>> check(
      X509_STORE_CTX_new());
  X509_STORE* const store = SSL_CTX_get_cert_store(context_.get());
  if (!check || X509_STORE_CTX_init(check.get(), store, certificate, chain) != 1) {
    return sys::take_openssl_error();
  }
  X509_STORE_CTX_set_default(check.get(), "ssl_client");
  X509_STORE_CTX_set_verify_cb(check.get(), accept_expired_list);
  if (X509_verify_cert(check.get()) == 1) {
    return std::nullopt;
  }
  ERR_clear_error();
  return X509_verify_cert_error_string(X509_STORE_CTX_get_error(check.get()));
}

routing::ClientRole role_in(const X509* certificate) {
  routing::ClientRole role =
      routing::role_of(sys::extensions_of(*certificate, routing::kRoleExtension));
  role.certificate = common_name_in(certificate);
  return role;
}

}  // namespace mbgate::io

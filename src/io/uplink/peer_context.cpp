// SPDX-License-Identifier: Apache-2.0
#include "io/uplink/peer_context.hpp"

#include <openssl/x509_vfy.h>
#include <openssl/x509v3.h>

#include <utility>

#include "base/assert.hpp"
#include "io/tls/pem_files.hpp"
#include "io/tls/remote_key.hpp"
#include "io/tls/signer_client.hpp"

namespace mbgate::io {
namespace {

using Wrong = std::optional<std::string>;

/// OpenSSL would tidy up at the end of the process, while a thread of an uplink may still use it.
/// Only its first initialisation can leave that out.
const int kNoTidying = OPENSSL_init_crypto(OPENSSL_INIT_NO_ATEXIT, nullptr);

Wrong use_key(SSL_CTX& context, const bus::TlsPeer& peer) {
  auto signer = SignerClient::open(peer.signer, peer.key);
  if (!signer) {
    return signer.error().why;
  }
  const sys::KeyHandle key = remote_key(*std::move(signer));
  if (!key || SSL_CTX_use_PrivateKey(&context, key.get()) != 1) {
    return peer.key + ": it is not the key of " + peer.certificate + " (" +
           sys::take_openssl_error() + ")";
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> expect_name(SSL& ssl, const std::string& name) {
  X509_VERIFY_PARAM* const wanted = SSL_get0_param(&ssl);
  // Of no name OpenSSL checks nothing, and an address ends for it at a zero.
  const bool is_name = !name.empty() && name.find('\0') == std::string::npos;
  if (is_name && X509_VERIFY_PARAM_set1_ip_asc(wanted, name.c_str()) == 1) {
    return std::nullopt;
  }
  ERR_clear_error();  // it is no address
  std::string told = name;
  if (!is_name || X509_VERIFY_PARAM_set1_host(wanted, name.c_str(), name.size()) != 1 ||
      SSL_ctrl(&ssl, SSL_CTRL_SET_TLSEXT_HOSTNAME, TLSEXT_NAMETYPE_host_name, told.data()) != 1) {
    return "server_name: no certificate can be for such a name (" + sys::take_openssl_error() + ")";
  }
  return std::nullopt;
}

Result<sys::SslHandle, std::string> make_peer(const bus::TlsPeer& peer) {
  MBGATE_ASSERT(kNoTidying == 1, "OpenSSL does not tidy up at the end");
  const sys::ContextHandle context(SSL_CTX_new(TLS_client_method()));
  if (!context || SSL_CTX_set_min_proto_version(context.get(), TLS1_2_VERSION) != 1) {
    return sys::take_openssl_error();
  }
  SSL_CTX_set_mode(context.get(),
                   SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  SSL_CTX_set_options(context.get(), SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION);
  SSL_CTX_set_verify(context.get(), SSL_VERIFY_PEER, accept_expired_list);
  Wrong wrong = use_certificate(*context, peer.certificate);
  if (wrong) {
    return *std::move(wrong);
  }
  if (auto trusted = use_authorities(*context, peer.authorities, peer.crl); !trusted) {
    return trusted.error();
  }
  wrong = use_key(*context, peer);
  if (wrong) {
    return *std::move(wrong);
  }
  sys::SslHandle ssl(SSL_new(context.get()));
  if (!ssl) {
    return sys::take_openssl_error();
  }
  wrong = expect_name(*ssl, peer.server_name);
  if (wrong) {
    return *std::move(wrong);
  }
  return ssl;
}

std::string objection_to_peer(const SSL& ssl, const std::string& server_name) {
  const long result = SSL_get_verify_result(&ssl);
  if (result == X509_V_OK) {
    return {};
  }
  const std::string text =
      std::string("certificate verify failed: ") + X509_verify_cert_error_string(result);
  return result == X509_V_ERR_HOSTNAME_MISMATCH || result == X509_V_ERR_IP_ADDRESS_MISMATCH
             ? text + ": it is not for " + server_name
             : text;
}

}  // namespace mbgate::io

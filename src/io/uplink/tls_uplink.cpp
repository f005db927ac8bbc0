// SPDX-License-Identifier: Apache-2.0
#include "io/uplink/tls_uplink.hpp"

#include <openssl/x509_vfy.h>
#include <sys/socket.h>

#include <array>
#include <chrono>
#include <fmt/core.h>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "base/assert.hpp"
#include "io/blocking_calls.hpp"
#include "io/tls/pem_files.hpp"
#include "io/tls/signer_client.hpp"
#include "sys/tls_stream.hpp"

namespace mbgate::io {
namespace {

using Wrong = std::optional<std::string>;

/// OpenSSL would tidy up at the end of the process, while a thread of an uplink may still use it.
/// Only its first initialisation can leave that out.
const int kNoTidying = OPENSSL_init_crypto(OPENSSL_INIT_NO_ATEXIT, nullptr);

Wrong use_key(SSL& ssl, const bus::TlsPeer& peer) {
  auto signer = SignerClient::open(peer.signer, peer.key);
  if (!signer) {
    return signer.error().why;
  }
  const sys::KeyHandle key = remote_key(*std::move(signer));
  if (!key || SSL_use_PrivateKey(&ssl, key.get()) != 1) {
    return fmt::format("{}: it is not the key of {} ({})", peer.key, peer.certificate,
                       sys::take_openssl_error());
  }
  return std::nullopt;
}

/// The TLS settings with which a line connects to a server: our certificate, whose key the signer
/// holds, and the authorities that we trust. The files are read for each connection, so that a
/// renewed one is used without a reload. Reading files and asking the signer may block.
Result<sys::SslHandle, std::string> make_peer(const bus::TlsPeer& peer) {
  MBGATE_ASSERT(kNoTidying == 1, "OpenSSL does not tidy up at the end");
  const sys::ContextHandle context = sys::client_context();
  if (!context) {
    return sys::take_openssl_error();
  }
  SSL_CTX_set_options(context.get(), SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION);
  SSL_CTX_set_verify(context.get(), SSL_VERIFY_PEER, accept_expired_list);
  Wrong wrong = use_certificate(*context, peer.certificate);
  if (wrong) {
    return *std::move(wrong);
  }
  if (auto trusted = use_authorities(*context, peer.authorities, peer.crl); !trusted) {
    return trusted.error();
  }
  sys::SslHandle ssl(SSL_new(context.get()));
  if (!ssl) {
    return sys::take_openssl_error();
  }
  wrong = use_key(*ssl, peer);
  if (wrong) {
    return *std::move(wrong);
  }
  if (!sys::expect_name(*ssl, peer.server_name)) {
    return fmt::format("server_name: no certificate can contain such a name ({})",
                       sys::take_openssl_error());
  }
  return ssl;
}

/// Why the server's certificate is not accepted; empty: it is, or there was none to look at.
std::string objection_to_peer(const SSL& ssl, const std::string& server_name) {
  const long result = SSL_get_verify_result(&ssl);
  if (result == X509_V_OK) {
    return {};
  }
  const std::string text =
      fmt::format("certificate verify failed: {}", X509_verify_cert_error_string(result));
  return result == X509_V_ERR_HOSTNAME_MISMATCH || result == X509_V_ERR_IP_ADDRESS_MISMATCH
             ? fmt::format("{}: it is not for {}", text, server_name)
             : text;
}

/// A server that does not take a frame for so long is given up, as by a line without TLS.
constexpr std::chrono::milliseconds kTakeTime{1000};

/// Why the stream came to its end; empty: the server closed it.
std::string why_over(const sys::TlsStream& stream, sys::TlsStream::Step step) {
  if (step == sys::TlsStream::Step::closed || stream.is_cut()) {
    return {};
  }
  if (step == sys::TlsStream::Step::flooded) {
    return fmt::format("TLS: the server sends {}", sys::TlsStream::kFlood);
  }
  return stream.system_error() != 0 ? std::generic_category().message(stream.system_error())
                                    : "TLS: " + sys::take_openssl_error();
}

std::string why_not_begun(const sys::TlsStream& stream, sys::TlsStream::Step step,
                          const std::string& server_name) {
  std::string why = objection_to_peer(stream.ssl(), server_name);
  why = why.empty() ? why_over(stream, step) : why;
  return why.empty() ? "the server closed the connection during the TLS handshake" : why;
}

std::string run_uplink(int server, int line, const bus::TlsPeer& peer) {
  using End = sys::TlsPump::End;
  auto ssl = make_peer(peer);
  if (!ssl) {
    return ssl.error();
  }
  SSL_set_connect_state(ssl->get());
  sys::TlsStream stream(*std::move(ssl), server);
  sys::TlsPump pump(stream, server, line);
  End end = pump.shake_hands(std::nullopt);
  if (end == End::stream) {
    return why_not_begun(stream, pump.last_step(), peer.server_name);
  }
  SSL_certs_clear(&stream.ssl());  // with the key goes the connection to the signer
  if (end == End::none) {
    const bool told = ::send(line, &TlsUplink::kReady, 1, MSG_DONTWAIT | MSG_NOSIGNAL) == 1;
    end = told ? pump.carry(kTakeTime) : End::plain;
  }
  if (end == End::stream) {
    return why_over(stream, pump.last_step());
  }
  if (pump.has_unsent()) {
    const linger reset{1, 0};  // throws it away
    ::setsockopt(server, SOL_SOCKET, SO_LINGER, &reset, sizeof reset);
  } else {
    stream.say_goodbye();
  }
  return end == End::late ? "the far end does not take a frame in time" : "";
}

}  // namespace

std::optional<TlsUplink> TlsUplink::start(sys::UniqueFd server, bus::TlsPeer peer) {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) != 0) {
    return std::nullopt;
  }
  sys::UniqueFd line_end(ends[0]);
  sys::UniqueFd our_end(ends[1]);
  std::promise<std::string> promise;
  std::shared_future<std::string> ended = promise.get_future().share();
  try {
    std::thread([promise = std::move(promise), server = std::move(server),
                 our_end = std::move(our_end), peer = std::move(peer)]() mutable {
      block_signals();
      promise.set_value(run_uplink(server.get(), our_end.get(), peer));
    }).detach();
  } catch (const std::system_error&) {
    return std::nullopt;
  }
  return TlsUplink(std::move(line_end), std::move(ended));
}

std::string TlsUplink::why() const {
  return ended_.wait_for(std::chrono::seconds(0)) == std::future_status::ready ? ended_.get() : "";
}

}  // namespace mbgate::io

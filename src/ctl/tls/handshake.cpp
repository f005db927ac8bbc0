// SPDX-License-Identifier: Apache-2.0
#include "ctl/tls/handshake.hpp"

#include <openssl/err.h>
#include <openssl/pem.h>
#include <pthread.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <fmt/core.h>
#include <future>
#include <optional>
#include <system_error>
#include <utility>

#include "ctl/control/connection_shell.hpp"
#include "ctl/visible_text.hpp"
#include "routing/client_address.hpp"
#include "sys/tls_stream.hpp"

namespace mbgate::ctl {
namespace {

using sys::expect_openssl;

constexpr int kOwnAlerts = SSL_AD_REASON_OFFSET;
constexpr const char* kClosed = "the server closed the connection";

/// Our certificate, our key and whom we trust; or which file is wrong, and why.
std::optional<std::string> load(SSL_CTX& context, const TlsIdentity& identity) {
  if (SSL_CTX_load_verify_file(&context, identity.authorities.c_str()) != 1) {
    return fmt::format("{}: {}", identity.authorities.string(), sys::take_openssl_error());
  }
  if (SSL_CTX_use_certificate_chain_file(&context, identity.certificate.c_str()) != 1) {
    return fmt::format("{}: {}", identity.certificate.string(), sys::take_openssl_error());
  }
  if (SSL_CTX_use_PrivateKey_file(&context, identity.key.c_str(), SSL_FILETYPE_PEM) != 1) {
    return fmt::format("{}: {}", identity.key.string(), sys::take_openssl_error());
  }
  return std::nullopt;
}

/// What is wrong with the server's certificate, and what to look at.
std::string verify_text(const SSL& session, const std::string& name, const TlsIdentity& identity) {
  const long result = SSL_get_verify_result(&session);
  std::string text =
      fmt::format("certificate verify failed: {}", X509_verify_cert_error_string(result));
  switch (result) {
    case X509_V_ERR_HOSTNAME_MISMATCH:
    case X509_V_ERR_IP_ADDRESS_MISMATCH:
      return fmt::format(
          "{}: the server's certificate is not for {}; if this is the right server, give "
          "--server-name",
          text, name);
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT_LOCALLY:
    case X509_V_ERR_SELF_SIGNED_CERT_IN_CHAIN:
    case X509_V_ERR_DEPTH_ZERO_SELF_SIGNED_CERT:
    case X509_V_ERR_CERT_SIGNATURE_FAILURE:
    case X509_V_ERR_UNABLE_TO_VERIFY_LEAF_SIGNATURE:
      return fmt::format("{}: no authority in {} has signed the server's certificate", text,
                         identity.authorities.string());
    default: return text;
  }
}

/// Why the stream is over after this step: "the server refused our certificate: certificate
/// expired".
std::string failure_text(const sys::TlsStream& stream, sys::TlsStream::Step step) {
  if (step == sys::TlsStream::Step::closed || stream.is_cut()) {
    return kClosed;
  }
  if (step == sys::TlsStream::Step::flooded) {
    return fmt::format("the server sends {}", sys::TlsStream::kFlood);
  }
  if (stream.system_error() != 0) {
    return std::generic_category().message(stream.system_error());
  }
  const unsigned long error = ERR_peek_last_error();
  const int reason = ERR_GET_REASON(error);
  std::string text = sys::take_openssl_error();
  if (ERR_SYSTEM_ERROR(error)) {
    return text;
  }
  switch (reason) {
    case SSL_R_WRONG_VERSION_NUMBER: return "the server does not speak TLS at this port";
    case SSL_R_TLSV13_ALERT_CERTIFICATE_REQUIRED:
    case SSL_R_SSLV3_ALERT_BAD_CERTIFICATE:
    case SSL_R_SSLV3_ALERT_CERTIFICATE_EXPIRED:
    case SSL_R_SSLV3_ALERT_CERTIFICATE_REVOKED:
    case SSL_R_SSLV3_ALERT_CERTIFICATE_UNKNOWN:
    case SSL_R_SSLV3_ALERT_UNSUPPORTED_CERTIFICATE:
    case SSL_R_TLSV1_ALERT_UNKNOWN_CA:
      return fmt::format("the server refused our certificate: {}",
                         SSL_alert_desc_string_long(reason - kOwnAlerts));
    default: break;
  }
  if (reason > kOwnAlerts) {
    return fmt::format("the server ended the handshake with an alert: {}",
                       SSL_alert_desc_string_long(reason - kOwnAlerts));
  }
  return text;
}

/// Nothing, where it is done.
std::optional<std::string> shake_hands(const sys::TlsStream& stream, sys::TlsPump& pump,
                                       Deadline deadline) {
  switch (pump.shake_hands(deadline)) {
    case sys::TlsPump::End::none: return std::nullopt;
    case sys::TlsPump::End::late: return "the server did not answer the TLS handshake in time";
    case sys::TlsPump::End::plain:
    case sys::TlsPump::End::stream: break;
  }
  std::string why = failure_text(stream, pump.last_step());
  return why == kClosed ? why + ": does it speak TLS at this port?" : why;
}

}  // namespace

Result<std::unique_ptr<TlsTunnel>, std::string> TlsTunnel::open(const std::string& host,
                                                                std::uint16_t port,
                                                                std::chrono::nanoseconds timeout,
                                                                const TlsIdentity& identity) {
  const Deadline deadline = std::chrono::steady_clock::now() + timeout;
  const sys::ContextHandle context = sys::client_context();
  expect_openssl(context.get());
  if (auto why = load(*context, identity)) {
    return *std::move(why);
  }
  auto socket = connect_tcp({host, port}, deadline);
  if (!socket) {
    return socket.error();
  }
  sys::SslHandle session(expect_openssl(SSL_new(context.get())));
  const std::string& name = identity.server_name.empty() ? host : identity.server_name;
  expect_openssl(sys::expect_name(*session, name) ? 1 : 0);
  SSL_set_connect_state(session.get());
  std::unique_ptr<TlsTunnel> tunnel(new TlsTunnel(*std::move(socket), std::move(session)));
  if (auto why = tunnel->start(deadline)) {
    const SSL& ssl = tunnel->stream_.ssl();
    return SSL_get_verify_result(&ssl) == X509_V_OK ? *std::move(why)
                                                    : verify_text(ssl, name, identity);
  }
  return tunnel;
}

TlsTunnel::TlsTunnel(sys::UniqueFd socket, sys::SslHandle session)
    : socket_(std::move(socket)), stream_(std::move(session), socket_.get()) {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw std::system_error(errno, std::generic_category(), "socketpair");
  }
  ours_ = sys::UniqueFd(ends[0]);
  theirs_ = sys::UniqueFd(ends[1]);
}

TlsTunnel::~TlsTunnel() {
  ::shutdown(ours_.get(), SHUT_RDWR);
  thread_.join();
}

std::optional<std::string> TlsTunnel::start(Deadline deadline) {
  std::promise<std::optional<std::string>> shaken;
  auto result = shaken.get_future();
  thread_ = std::thread([this, deadline, shaken = std::move(shaken)]() mutable {
    // Signals are for the thread that waits for them. And OpenSSL writes without MSG_NOSIGNAL: a
    // server that is gone must not end the process.
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, nullptr);
    sys::TlsPump pump(stream_, socket_.get(), ours_.get());
    auto why = shake_hands(stream_, pump, deadline);
    const bool is_done = !why;
    shaken.set_value(std::move(why));
    if (is_done) {
      carry(pump);
    }
  });
  return result.get();
}

std::string TlsTunnel::why_ended() const { return has_ended_ ? why_ended_ : std::string(); }

void TlsTunnel::carry(sys::TlsPump& pump) {
  const bool is_server_gone = pump.carry(std::nullopt) == sys::TlsPump::End::stream;
  if (is_server_gone) {
    why_ended_ = failure_text(stream_, pump.last_step());
  }
  has_ended_ = true;
  if (!is_server_gone) {
    stream_.say_goodbye();
  }
  ::shutdown(ours_.get(), SHUT_RDWR);
}

std::string role_in_file(const std::filesystem::path& file) {
  const sys::BioHandle input(BIO_new_file(file.c_str(), "r"));
  const sys::CertificateHandle certificate(
      input ? PEM_read_bio_X509(input.get(), nullptr, nullptr, nullptr) : nullptr);
  if (!certificate) {
    ERR_clear_error();
    return {};
  }
  const auto role = routing::role_of(sys::extensions_of(*certificate, routing::kRoleExtension));
  if (role.kind == routing::ClientRole::Kind::unreadable) {
    return "unreadable: a gateway answers every request with exception 01";
  }
  std::string text = "\"";
  for (const char it : visible_text(role.name)) {
    text.append(it == '"' || it == '\\' ? "\\" : "").push_back(it);
  }
  return role.name.empty() ? "none: the NULL role, which rules write as \"\"" : text + "\"";
}

}  // namespace mbgate::ctl

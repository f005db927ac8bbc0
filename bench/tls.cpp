// SPDX-License-Identifier: Apache-2.0
#include "tls.hpp"

#include <fcntl.h>
#include <openssl/err.h>
#include <poll.h>
#include <sched.h>
#include <sys/socket.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <stdexcept>
#include <string>

#include "load.hpp"

namespace mbgate::bench {
namespace {

[[noreturn]] void fail_at(const std::string& what) {
  const char* const reason = ::ERR_reason_error_string(::ERR_peek_last_error());
  throw std::runtime_error(what + ": " + (reason == nullptr ? "the connection is lost" : reason));
}

bool must_wait(const SSL& session, int result) {
  const int wish = ::SSL_get_error(&session, result);
  return wish == SSL_ERROR_WANT_READ || wish == SSL_ERROR_WANT_WRITE;
}

}  // namespace

TlsClients::TlsClients(const TlsFiles& files) : context_(::SSL_CTX_new(::TLS_client_method())) {
  std::signal(SIGPIPE, SIG_IGN);  // OpenSSL writes without MSG_NOSIGNAL
  SSL_CTX* const context = context_.get();
  ::SSL_CTX_set_verify(context, SSL_VERIFY_PEER, nullptr);
  if (context == nullptr || ::SSL_CTX_load_verify_file(context, files.authorities.c_str()) != 1 ||
      ::SSL_CTX_use_certificate_chain_file(context, files.certificate.c_str()) != 1 ||
      ::SSL_CTX_use_PrivateKey_file(context, files.key.c_str(), SSL_FILETYPE_PEM) != 1) {
    fail_at("the certificates of the clients");
  }
}

TlsSession TlsClients::shake_hands(int socket) const {
  TlsSession session(::SSL_new(context_.get()));
  ::ERR_clear_error();
  if (!session || ::SSL_set_fd(session.get(), socket) != 1 || ::SSL_connect(session.get()) != 1) {
    fail_at("a TLS handshake failed");
  }
  return session;
}

Stream::Stream(sys::UniqueFd socket, const TlsClients* tls) : socket_(std::move(socket)) {
  if (tls != nullptr) {
    session_ = tls->shake_hands(socket_.get());
    ::fcntl(socket_.get(), F_SETFL, ::fcntl(socket_.get(), F_GETFL) | O_NONBLOCK);
  }
}

void Stream::close() {
  session_.reset();
  socket_.reset(-1);
}

bool Stream::send(std::span<const std::uint8_t> bytes) {
  const auto size = static_cast<int>(bytes.size());
  if (!session_) {
    return ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL) == size;
  }
  ::ERR_clear_error();
  int count = 0;
  while ((count = ::SSL_write(session_.get(), bytes.data(), size)) <= 0) {
    if (!must_wait(*session_, count)) {
      return false;
    }
    pollfd room{socket_.get(), POLLOUT, 0};
    ::poll(&room, 1, -1);
  }
  return count == size;
}

std::ptrdiff_t Stream::receive(std::span<std::uint8_t> bytes) {
  if (session_) {
    ::ERR_clear_error();
    const int count = ::SSL_read(session_.get(), bytes.data(), static_cast<int>(bytes.size()));
    return count > 0 ? count : must_wait(*session_, count) ? -1 : 0;
  }
  const ssize_t count = ::recv(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
  return count < 0 && (errno == EAGAIN || errno == EINTR) ? -1 : count < 0 ? 0 : count;
}

void run_handshakes(const TlsFiles& files, std::uint16_t port, std::uint64_t& done) {
  const sched_param none{};
  ::sched_setscheduler(0, SCHED_IDLE, &none);
  const TlsClients clients(files);
  for (;;) {
    const auto socket = connect_to(port);
    const auto session = clients.shake_hands(socket.get());
    // In TLS 1.3 the server has not looked at the client's certificate yet: only its goodbye says
    // that it has.
    ::SSL_shutdown(session.get());
    char byte = 0;
    while (::SSL_read(session.get(), &byte, 1) > 0) {
    }
    if ((::SSL_get_shutdown(session.get()) & SSL_RECEIVED_SHUTDOWN) == 0) {
      fail_at("a TLS handshake was not to the server's liking");
    }
    std::atomic_ref(done).fetch_add(1, std::memory_order_relaxed);
  }
}

}  // namespace mbgate::bench

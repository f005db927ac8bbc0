// SPDX-License-Identifier: Apache-2.0
// The handshake of a client, and what becomes of one that fails.
#include <sys/socket.h>

#include <array>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <cerrno>

#include "io/supervise.hpp"
#include "io/tls/tls_client.hpp"

namespace mbgate::io {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

constexpr std::size_t kDroppedAtOnce = 2048;
/// How long a client may take to read why it was refused: a close with unread bytes resets the
/// connection, and the alert could be lost.
constexpr std::chrono::seconds kAlertLimit{1};
constexpr const char* kTookTooLong = "it took too long (handshake_timeout)";

}  // namespace

boost::asio::awaitable<std::optional<std::string>> TlsClient::shake_hands(
    gateway::HandshakeSettings limits, std::function<void()> greeted) {
  const auto begin = boost::asio::steady_timer::clock_type::now();
  if (limits.hello < limits.timeout) {
    end_at(begin + limits.hello, "no ClientHello came in time (hello_timeout)");
  } else {
    end_at(begin + limits.timeout, kTookTooLong);
  }
  while (socket_.is_open()) {
    const Step step = note(stream_.shake_hands());
    if (!has_greeted_ && has_hello()) {
      has_greeted_ = true;
      end_at(begin + limits.timeout, kTookTooLong);
      greeted();
    }
    if (step == Step::done) {
      SSL_certs_clear(&stream_.ssl());
      timer_.cancel();
      co_return std::nullopt;
    }
    if (sys::is_over(step) || !co_await wait_for(step)) {
      break;
    }
  }
  co_return complaint_.empty() ? std::string("the client has gone") : complaint_;
}

bool TlsClient::has_hello() const {
  const OSSL_HANDSHAKE_STATE state = SSL_get_state(&stream_.ssl());
  return state != TLS_ST_BEFORE && state != TLS_ST_SR_CLNT_HELLO;
}

boost::asio::awaitable<void> TlsClient::drain_and_end() {
  error_code ignored;
  socket_.shutdown(tcp::socket::shutdown_send, ignored);
  end_at(boost::asio::steady_timer::clock_type::now() + kAlertLimit);
  std::array<std::uint8_t, kDroppedAtOnce> bytes{};
  ssize_t count = 1;
  while (count != 0 && socket_.is_open() && co_await wait_for(Step::read_more)) {
    count = ::recv(socket_.native_handle(), bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (count < 0 && errno != EAGAIN && errno != EINTR) {
      break;
    }
  }
  end();
}

TlsClient::Step TlsClient::note(Step step) {
  if (step == Step::flooded) {
    complaint_ = sys::TlsStream::kFlood;
  } else if (step == Step::broken && ERR_peek_error() != 0) {
    complaint_ = sys::take_openssl_error();
    if (const long result = SSL_get_verify_result(&stream_.ssl()); result != X509_V_OK) {
      complaint_ += std::string(": ") + X509_verify_cert_error_string(result);
    }
  }
  return step;
}

boost::asio::awaitable<bool> TlsClient::wait_for(Step step) {
  if (step == Step::again) {
    co_await boost::asio::post(shared_.io, boost::asio::use_awaitable);  // others go on
    co_return socket_.is_open();
  }
  const auto what = step == Step::write_more ? tcp::socket::wait_write : tcp::socket::wait_read;
  const auto [error] = co_await socket_.async_wait(what, kAsTuple);
  co_return !error && socket_.is_open();
}

}  // namespace mbgate::io

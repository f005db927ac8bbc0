// SPDX-License-Identifier: Apache-2.0
#include "io/uplink/tls_uplink.hpp"

#include <linux/sockios.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <mutex>
#include <optional>
#include <span>
#include <system_error>
#include <thread>
#include <utility>

#include "io/blocking_calls.hpp"
#include "io/clock.hpp"
#include "io/tls/record_gate.hpp"
#include "io/uplink/peer_context.hpp"

namespace mbgate::io {

struct TlsUplink::Shared {
  std::mutex mutex;
  std::string why;  ///< under the mutex
};

namespace {

/// A server that does not take a frame for so long is given up, as by a line without TLS.
constexpr int kTakeMilliseconds = 1000;

/// Bytes on their way in one direction.
struct Portion {
  std::array<std::uint8_t, 2048> bytes{};
  std::size_t begin = 0;
  std::size_t end = 0;

  [[nodiscard]] bool is_empty() const { return begin == end; }
  [[nodiscard]] std::span<const std::uint8_t> left() const {
    return std::span(bytes).subspan(begin, end - begin);
  }
};

enum class Move { done, must_wait, ended };

class UplinkPump {
 public:
  UplinkPump(SSL& ssl, int server, int line, std::string server_name)
      : ssl_(ssl), server_(server), line_(line), server_name_(std::move(server_name)) {
    records_.watch(ssl);
  }

  /// Why it ended; empty: the line or the server closed it.
  std::string run() {
    if (shake_hands()) {
      carry();
    }
    return std::move(why_);
  }

  [[nodiscard]] bool has_line_gone() const { return has_line_gone_; }
  /// Do we, or does the kernel, hold what the server has not taken?
  [[nodiscard]] bool has_unsent() const {
    int unacknowledged = 0;
    return !up_.is_empty() ||
           (::ioctl(server_, SIOCOUTQ, &unacknowledged) == 0 && unacknowledged > 0);
  }

 private:
  bool shake_hands() {
    for (;;) {
      prepare();
      events_ = 0;
      const int result = SSL_connect(&ssl_);
      if (result == 1) {
        return ::send(line_, &TlsUplink::kReady, 1, MSG_DONTWAIT | MSG_NOSIGNAL) == 1;
      }
      const Move move = ask(result);
      if (move == Move::ended) {
        note_handshake_failure();
        return false;
      }
      if (move == Move::must_wait && !wait()) {
        return false;
      }
    }
  }

  void carry() {
    for (;;) {
      events_ = 0;
      const Move down = carry_down();
      const Move up = down == Move::ended ? down : carry_up();
      if (up == Move::ended || down == Move::ended) {
        return;
      }
      if (up == Move::must_wait && down == Move::must_wait && !wait_to_carry()) {
        return;
      }
    }
  }

  Move carry_up() {
    if (up_.is_empty()) {
      const ssize_t count = ::recv(line_, up_.bytes.data(), up_.bytes.size(), MSG_DONTWAIT);
      if (count < 0 && (errno == EAGAIN || errno == EINTR)) {
        return Move::must_wait;
      }
      if (count <= 0 || is_line_closed()) {
        has_line_gone_ = true;
        return Move::ended;
      }
      up_.begin = 0;
      up_.end = static_cast<std::size_t>(count);
    }
    const auto left = up_.left();
    prepare();
    const int count = SSL_write(&ssl_, left.data(), static_cast<int>(left.size()));
    if (count > 0) {
      up_.begin += static_cast<std::size_t>(count);
      return Move::done;
    }
    const Move move = ask(count);
    if (move == Move::ended && down_.is_empty()) {
      carry_down();  // an alert says more than that the server does not listen any more
    }
    return move;
  }

  Move carry_down() {
    if (down_.is_empty()) {
      prepare();
      const int count = SSL_read(&ssl_, down_.bytes.data(), static_cast<int>(down_.bytes.size()));
      if (count <= 0) {
        return ask(count);
      }
      down_.begin = 0;
      down_.end = static_cast<std::size_t>(count);
    }
    const auto left = down_.left();
    const ssize_t count = ::send(line_, left.data(), left.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (count < 0) {
      has_line_gone_ = errno != EAGAIN && errno != EINTR;
      return has_line_gone_ ? Move::ended : Move::must_wait;
    }
    down_.begin += static_cast<std::size_t>(count);
    return Move::done;
  }

  void prepare() {
    ERR_clear_error();
    records_.open();
  }

  Move ask(int result) {
    const int system_error = errno;
    const int wish = SSL_get_error(&ssl_, result);
    if (wish == SSL_ERROR_WANT_READ || wish == SSL_ERROR_WANT_WRITE) {
      return ask_for(wish == SSL_ERROR_WANT_READ ? POLLIN : POLLOUT);
    }
    const bool closed = wish == SSL_ERROR_ZERO_RETURN || is_unexpected_end();
    if (wish == SSL_ERROR_SYSCALL && system_error != 0 && ERR_peek_error() == 0) {
      why_ = std::generic_category().message(system_error);
    } else if (!closed) {
      why_ = "TLS: " + take_openssl_error();
    }
    ERR_clear_error();
    return Move::ended;
  }

  /// There may be more records, of which the socket says nothing: `done` is to try again.
  Move ask_for(short events) {
    const RecordGate::Turn turn = records_.turn(now());
    if (turn == RecordGate::Turn::too_many) {
      why_ = std::string("TLS: the server sends ") + RecordGate::kTooMany;
      return Move::ended;
    }
    events_ = static_cast<short>(events_ | events);
    return turn == RecordGate::Turn::again && events == POLLIN ? Move::done : Move::must_wait;
  }

  static bool is_unexpected_end() {
    const unsigned long error = ERR_peek_last_error();
    return error == 0 || ERR_GET_REASON(error) == SSL_R_UNEXPECTED_EOF_WHILE_READING;
  }

  void note_handshake_failure() {
    if (auto objection = objection_to_peer(ssl_, server_name_); !objection.empty()) {
      why_ = std::move(objection);
    } else if (why_.empty()) {
      why_ = "the server closed the connection during the TLS handshake";
    }
  }

  [[nodiscard]] bool is_line_closed() const {
    pollfd line{line_, 0, 0};
    return ::poll(&line, 1, 0) > 0 && (line.revents & POLLHUP) != 0;
  }

  /// For the server; false: the line has closed its end.
  bool wait() {
    std::array<pollfd, 2> watched{pollfd{server_, events_, 0}, pollfd{line_, 0, 0}};
    ::poll(watched.data(), watched.size(), -1);
    has_line_gone_ = (watched[1].revents & POLLHUP) != 0;
    return !has_line_gone_;
  }

  /// Either for the server, or for the line.
  bool wait_to_carry() {
    const bool sending = !up_.is_empty();
    const auto line = static_cast<short>((sending ? 0 : POLLIN) | (down_.is_empty() ? 0 : POLLOUT));
    std::array<pollfd, 2> watched{pollfd{server_, events_, 0}, pollfd{line_, line, 0}};
    const int ready = ::poll(watched.data(), watched.size(), sending ? kTakeMilliseconds : -1);
    if (ready == 0) {
      why_ = "the far end does not take a frame in time";
      has_line_gone_ = true;
    } else if ((watched[1].revents & POLLHUP) != 0) {
      has_line_gone_ = true;
    }
    return !has_line_gone_;
  }

  RecordGate records_;
  SSL& ssl_;
  int server_;
  int line_;
  std::string server_name_;
  short events_ = 0;  ///< that the server is waited for
  bool has_line_gone_ = false;
  Portion up_;
  Portion down_;
  std::string why_;
};

std::string run_uplink(int server, int line, const bus::TlsPeer& peer) {
  const auto ssl = make_peer(peer);
  if (!ssl) {
    return ssl.error();
  }
  if (SSL_set_fd(ssl->get(), server) != 1) {
    return take_openssl_error();
  }
  UplinkPump pump(**ssl, server, line, peer.server_name);
  std::string why = pump.run();
  if (pump.has_line_gone() && pump.has_unsent()) {
    const linger reset{1, 0};  // throws it away
    ::setsockopt(server, SOL_SOCKET, SO_LINGER, &reset, sizeof reset);
  } else if (pump.has_line_gone()) {
    SSL_shutdown(ssl->get());
  }
  return why;
}

}  // namespace

TlsUplink::TlsUplink(std::shared_ptr<Shared> shared, UniqueFd line_end)
    : shared_(std::move(shared)), line_end_(std::move(line_end)) {}

std::unique_ptr<TlsUplink> TlsUplink::start(UniqueFd server, bus::TlsPeer peer) {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) != 0) {
    return nullptr;
  }
  UniqueFd line_end(ends[0]);
  UniqueFd our_end(ends[1]);
  auto shared = std::make_shared<Shared>();
  try {
    std::thread([shared, server = std::move(server), our_end = std::move(our_end),
                 peer = std::move(peer)] {
      block_signals();
      std::string why = run_uplink(server.get(), our_end.get(), peer);
      const std::lock_guard lock(shared->mutex);
      shared->why = std::move(why);
    }).detach();
  } catch (const std::system_error&) {
    return nullptr;
  }
  return std::unique_ptr<TlsUplink>(new TlsUplink(std::move(shared), std::move(line_end)));
}

std::string TlsUplink::why() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->why;
}

}  // namespace mbgate::io

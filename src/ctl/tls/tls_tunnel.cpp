// SPDX-License-Identifier: Apache-2.0
#include "ctl/tls/tls_tunnel.hpp"

#include <openssl/err.h>
#include <poll.h>
#include <pthread.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <optional>
#include <span>
#include <system_error>

namespace mbgate::ctl {
namespace {

/// Bytes on their way in one direction.
struct Carried {
  std::array<char, 4096> bytes;
  std::size_t begin = 0;
  std::size_t end = 0;

  [[nodiscard]] bool is_empty() const { return begin == end; }
  [[nodiscard]] std::span<const char> left() const {
    return std::span(bytes).subspan(begin, end - begin);
  }
  void sent(std::size_t count) { begin += count; }
  void filled(std::size_t count) {
    begin = 0;
    end = count;
  }
};

/// What became of one attempt to carry something on.
enum class Step { done, must_wait, ended };

class Carrier {
 public:
  Carrier(SSL& session, int server, int client)
      : session_(session), server_(server), client_(client) {}

  /// Until the client or the server is gone. The text is why the server is.
  std::string run() {
    for (;;) {
      wish_ = POLLIN;
      const Step down = carry_down();
      const Step up = down == Step::ended ? down : carry_up();
      if (up == Step::ended || down == Step::ended) {
        return why_;
      }
      if (up == Step::must_wait && down == Step::must_wait) {
        wait();
      }
    }
  }

 private:
  Step carry_up() {
    if (up_.is_empty()) {
      const ssize_t count = ::recv(client_, up_.bytes.data(), up_.bytes.size(), MSG_DONTWAIT);
      if (count < 0 && (errno == EAGAIN || errno == EINTR)) {
        return Step::must_wait;
      }
      if (count <= 0) {
        return Step::ended;
      }
      up_.filled(static_cast<std::size_t>(count));
    }
    const auto left = up_.left();
    ERR_clear_error();
    const int count = SSL_write(&session_, left.data(), static_cast<int>(left.size()));
    if (count <= 0) {
      const Step step = ask(count);
      if (step == Step::ended && down_.is_empty()) {
        carry_down();  // what the server said last says more than that it does not listen any more
      }
      return step;
    }
    up_.sent(static_cast<std::size_t>(count));
    return Step::done;
  }

  Step carry_down() {
    if (down_.is_empty()) {
      ERR_clear_error();
      const int count =
          SSL_read(&session_, down_.bytes.data(), static_cast<int>(down_.bytes.size()));
      if (count <= 0) {
        return ask(count);
      }
      down_.filled(static_cast<std::size_t>(count));
    }
    const auto left = down_.left();
    const ssize_t count = ::send(client_, left.data(), left.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (count < 0) {
      return errno == EAGAIN || errno == EINTR ? Step::must_wait : Step::ended;
    }
    down_.sent(static_cast<std::size_t>(count));
    return Step::done;
  }

  /// What the session needs to go on.
  Step ask(int result) {
    const int wish = SSL_get_error(&session_, result);
    if (wish == SSL_ERROR_WANT_READ || wish == SSL_ERROR_WANT_WRITE) {
      wish_ |= wish == SSL_ERROR_WANT_WRITE ? POLLOUT : 0;
      return Step::must_wait;
    }
    why_ = failure_text(session_, result);
    return Step::ended;
  }

  void wait() const {
    std::array<pollfd, 2> watched{
        pollfd{server_, static_cast<short>(down_.is_empty() ? wish_ : wish_ & POLLOUT), 0},
        pollfd{client_,
               static_cast<short>((up_.is_empty() ? POLLIN : 0) | (down_.is_empty() ? 0 : POLLOUT)),
               0}};
    ::poll(watched.data(), watched.size(), -1);
  }

  SSL& session_;
  int server_;
  int client_;
  int wish_ = POLLIN;
  Carried up_{};
  Carried down_{};
  std::string why_;
};

}  // namespace

TlsTunnel::TlsTunnel(TlsConnection connection) : connection_(std::move(connection)) {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw std::system_error(errno, std::generic_category(), "socketpair");
  }
  ours_ = Descriptor(ends[0]);
  theirs_ = Descriptor(ends[1]);
  thread_ = std::thread([this] { carry(); });
}

TlsTunnel::~TlsTunnel() {
  ::shutdown(ours_.get(), SHUT_RDWR);
  thread_.join();
}

std::string TlsTunnel::why_ended() const { return has_ended_ ? why_ended_ : std::string(); }

void TlsTunnel::carry() {
  sigset_t all;
  sigfillset(&all);  // signals are for the thread that waits for them
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
  why_ended_ = Carrier(*connection_.session, connection_.socket.get(), ours_.get()).run();
  has_ended_ = true;
  if (why_ended_.empty()) {
    SSL_shutdown(connection_.session.get());
  }
  ::shutdown(ours_.get(), SHUT_RDWR);
}

}  // namespace mbgate::ctl

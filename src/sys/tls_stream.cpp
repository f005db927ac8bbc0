// SPDX-License-Identifier: Apache-2.0
#include "sys/tls_stream.hpp"

#include <linux/sockios.h>
#include <openssl/bio.h>
#include <openssl/x509v3.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "sys/unique_fd.hpp"

namespace mbgate::sys {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kForEver{-1};

/// A handshake needs some ten, and renewing keys one a day.
constexpr int kMostWithoutData = 100;  // within a second

}  // namespace

void RecordGate::watch(SSL& ssl) {
  BIO* const bio = SSL_get_rbio(&ssl);
  BIO_set_callback_arg(bio, reinterpret_cast<char*>(this));
  BIO_set_callback_ex(bio, on_read);
}

RecordGate::Turn RecordGate::turn(Instant at) {
  if (!has_passed_) {
    return Turn::wait;
  }
  constexpr std::chrono::nanoseconds kSecond = std::chrono::seconds(1);
  const Instant rested = std::max(rested_at_, at) + kSecond / kMostWithoutData;
  if (rested - kSecond > at) {
    return Turn::too_many;
  }
  rested_at_ = rested;
  return Turn::again;
}

// Called before and after (BIO_CB_RETURN) each operation of the BIO.
long RecordGate::on_read(BIO* bio, int what, const char* bytes, std::size_t /*size*/,
                         int /*argument*/, long /*number*/, int result, std::size_t* processed) {
  auto* const gate = reinterpret_cast<RecordGate*>(BIO_get_callback_arg(bio));
  if (what == BIO_CB_READ && gate->has_passed_ && gate->head_size_ == 0) {
    BIO_clear_retry_flags(bio);
    BIO_set_retry_read(bio);
    return -1;
  }
  if (what == (BIO_CB_READ | BIO_CB_RETURN) && result > 0) {
    gate->note({bytes, *processed});
  }
  return (what & BIO_CB_RETURN) != 0 ? result : 1;
}

void RecordGate::note(std::span<const char> bytes) {
  while (!bytes.empty()) {
    std::size_t taken = 1;
    if (head_size_ < head_.size()) {
      head_[head_size_++] = static_cast<std::uint8_t>(bytes.front());
      left_ = size_left();
    } else {
      taken = std::min(left_, bytes.size());
      left_ -= taken;
    }
    bytes = bytes.subspan(taken);
    if (head_size_ == head_.size() && left_ == 0) {
      has_passed_ = true;
      head_size_ = 0;
    }
  }
}

/// Of the record behind its head. The first one of a connection may be of SSL 2.0, whose head has
/// two bytes (RFC 5246, E.2).
std::size_t RecordGate::size_left() const {
  if ((head_[0] & 0x80U) != 0) {
    const std::size_t size = (head_[0] & 0x7FU) << 8U | head_[1];
    return size + 2 > head_.size() ? size + 2 - head_.size() : 0;
  }
  return static_cast<std::size_t>(head_[3] << 8U | head_[4]);
}

TlsStream::TlsStream(SslHandle ssl, int socket) : ssl_(std::move(ssl)) {
  expect_openssl(SSL_set_fd(ssl_.get(), socket));
  records_.watch(*ssl_);
}

TlsStream::Step TlsStream::shake_hands() {
  prepare();
  return step_after(SSL_do_handshake(ssl_.get()));
}

TlsStream::Step TlsStream::read(std::span<std::uint8_t> room, std::size_t& count) {
  prepare();
  return step_after(SSL_read_ex(ssl_.get(), room.data(), room.size(), &count));
}

TlsStream::Step TlsStream::write(std::span<const std::uint8_t> bytes, std::size_t& count) {
  prepare();
  return step_after(SSL_write_ex(ssl_.get(), bytes.data(), bytes.size(), &count));
}

// 0: the other end has not said it yet.
TlsStream::Step TlsStream::say_goodbye() {
  prepare();
  const int result = SSL_shutdown(ssl_.get());
  return result >= 0 ? Step::done : step_after(result);
}

void TlsStream::prepare() {
  ERR_clear_error();
  errno = 0;
  records_.open();
}

TlsStream::Step TlsStream::step_after(int result) {
  const int system_error = errno;
  switch (SSL_get_error(ssl_.get(), result)) {
    case SSL_ERROR_NONE: return Step::done;
    case SSL_ERROR_WANT_READ: return step_to_wait(Step::again);
    case SSL_ERROR_WANT_WRITE: return step_to_wait(Step::write_more);
    case SSL_ERROR_ZERO_RETURN: return Step::closed;
    case SSL_ERROR_SYSCALL: system_error_ = ERR_peek_error() == 0 ? system_error : 0; break;
    default: break;
  }
  const unsigned long error = ERR_peek_last_error();
  is_cut_ = system_error_ == 0 &&
            (error == 0 || ERR_GET_REASON(error) == SSL_R_UNEXPECTED_EOF_WHILE_READING);
  return Step::broken;
}

TlsStream::Step TlsStream::step_to_wait(Step wish) {
  switch (records_.turn(RecordGate::Instant::clock::now())) {
    case RecordGate::Turn::again: return wish;
    case RecordGate::Turn::wait: return wish == Step::again ? Step::read_more : wish;
    case RecordGate::Turn::too_many: break;
  }
  return Step::flooded;
}

ContextHandle client_context() {
  ContextHandle context(SSL_CTX_new(TLS_client_method()));
  if (!context || SSL_CTX_set_min_proto_version(context.get(), TLS1_2_VERSION) != 1) {
    return nullptr;
  }
  SSL_CTX_set_verify(context.get(), SSL_VERIFY_PEER, nullptr);
  SSL_CTX_set_mode(context.get(),
                   SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  return context;
}

// Of no name OpenSSL checks nothing, and an address ends for it at a zero.
bool expect_name(SSL& ssl, const std::string& name) {
  if (name.empty() || name.find('\0') != std::string::npos) {
    return false;
  }
  X509_VERIFY_PARAM* const wanted = SSL_get0_param(&ssl);
  if (X509_VERIFY_PARAM_set1_ip_asc(wanted, name.c_str()) == 1) {
    return true;
  }
  ERR_clear_error();  // it is no address
  std::string told = name;
  return X509_VERIFY_PARAM_set1_host(wanted, name.c_str(), name.size()) == 1 &&
         SSL_ctrl(&ssl, SSL_CTRL_SET_TLSEXT_HOSTNAME, TLSEXT_NAMETYPE_host_name, told.data()) == 1;
}

bool TlsPump::has_unsent() const {
  int unacknowledged = 0;
  return !up_.is_empty() ||
         (::ioctl(socket_, SIOCOUTQ, &unacknowledged) == 0 && unacknowledged > 0);
}

TlsPump::End TlsPump::shake_hands(std::optional<steady_clock::time_point> limit) {
  while (end_ == End::none) {
    events_ = 0;
    const TlsStream::Step step = stream_.shake_hands();
    if (step == TlsStream::Step::done) {
      break;
    }
    if (move_after(step) == Move::must_wait) {
      wait(0, limit ? std::chrono::ceil<milliseconds>(
                          std::max(*limit - steady_clock::now(), steady_clock::duration::zero()))
                    : kForEver);
    }
  }
  return end_;
}

TlsPump::End TlsPump::carry(std::optional<milliseconds> stall_limit) {
  while (end_ == End::none) {
    events_ = 0;
    const Move down = carry_down();
    const Move up = down == Move::ended ? down : carry_up();
    if (up == Move::must_wait && down == Move::must_wait) {
      const bool sends = !up_.is_empty();
      wait(static_cast<short>((sends ? 0 : POLLIN) | (down_.is_empty() ? 0 : POLLOUT)),
           sends ? stall_limit.value_or(kForEver) : kForEver);
    }
  }
  return end_;
}

TlsPump::Move TlsPump::carry_up() {
  if (up_.is_empty()) {
    const ssize_t count = ::recv(plain_, up_.bytes.data(), up_.bytes.size(), MSG_DONTWAIT);
    if (count < 0 && would_block(errno)) {
      return Move::must_wait;
    }
    if (count <= 0 || is_plain_closed()) {
      return end_with(End::plain);
    }
    up_.fill(static_cast<std::size_t>(count));
  }
  std::size_t count = 0;
  const TlsStream::Step step = stream_.write(up_.left(), count);
  if (step == TlsStream::Step::done) {
    up_.begin += count;
    return Move::done;
  }
  if (is_over(step) && down_.is_empty() && carry_down() == Move::ended) {
    return Move::ended;  // an alert says more than that the other end does not listen any more
  }
  return move_after(step);
}

TlsPump::Move TlsPump::carry_down() {
  if (down_.is_empty()) {
    std::size_t count = 0;
    const TlsStream::Step step = stream_.read(down_.bytes, count);
    if (step != TlsStream::Step::done) {
      return move_after(step);
    }
    down_.fill(count);
  }
  const auto left = down_.left();
  const ssize_t count = ::send(plain_, left.data(), left.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  if (count < 0) {
    return would_block(errno) ? Move::must_wait : end_with(End::plain);
  }
  down_.begin += static_cast<std::size_t>(count);
  return Move::done;
}

TlsPump::Move TlsPump::move_after(TlsStream::Step step) {
  last_step_ = step;
  switch (step) {
    case TlsStream::Step::done:
    case TlsStream::Step::again: return Move::done;
    case TlsStream::Step::read_more: events_ |= POLLIN; return Move::must_wait;
    case TlsStream::Step::write_more: events_ |= POLLOUT; return Move::must_wait;
    case TlsStream::Step::closed:
    case TlsStream::Step::broken:
    case TlsStream::Step::flooded: break;
  }
  return end_with(End::stream);
}

TlsPump::Move TlsPump::end_with(End end) {
  end_ = end;
  return Move::ended;
}

bool TlsPump::is_plain_closed() const {
  pollfd plain{plain_, 0, 0};
  return ::poll(&plain, 1, 0) > 0 && (plain.revents & POLLHUP) != 0;
}

void TlsPump::wait(short plain_events, milliseconds time) {
  std::array<pollfd, 2> watched{pollfd{socket_, events_, 0}, pollfd{plain_, plain_events, 0}};
  const int ready = ::poll(watched.data(), watched.size(), static_cast<int>(time.count()));
  if (ready == 0) {
    end_ = End::late;
  } else if ((watched[1].revents & POLLHUP) != 0) {
    end_ = End::plain;
  }
}

}  // namespace mbgate::sys

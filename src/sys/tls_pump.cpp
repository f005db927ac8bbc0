// SPDX-License-Identifier: Apache-2.0
#include "sys/tls_pump.hpp"

#include <linux/sockios.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>

#include "sys/unique_fd.hpp"

namespace mbgate::sys {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kForEver{-1};

}  // namespace

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

TlsPump::End TlsPump::carry(std::optional<milliseconds> patience) {
  while (end_ == End::none) {
    events_ = 0;
    const Move down = carry_down();
    const Move up = down == Move::ended ? down : carry_up();
    if (up == Move::must_wait && down == Move::must_wait) {
      const bool sends = !up_.is_empty();
      wait(static_cast<short>((sends ? 0 : POLLIN) | (down_.is_empty() ? 0 : POLLOUT)),
           sends ? patience.value_or(kForEver) : kForEver);
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

// SPDX-License-Identifier: Apache-2.0
#include "io/clients/hangup_watch.hpp"

#include <sys/epoll.h>

#include <array>
#include <cerrno>
#include <span>
#include <system_error>
#include <utility>

#include "io/supervise.hpp"

namespace mbgate::io {
namespace {

constexpr std::size_t kEventsAtOnce = 64;

int make_epoll() {
  const int fd = ::epoll_create1(EPOLL_CLOEXEC);
  if (fd < 0) {
    throw std::system_error(errno, std::generic_category(), "epoll_create1");
  }
  return fd;
}

}  // namespace

HangupWatch::HangupWatch(boost::asio::io_context& context, Callback callback)
    : epoll_(context, make_epoll()), callback_(std::move(callback)) {
  supervise(context, run(), "hang-up watch");
}

bool HangupWatch::watch(int socket, std::uint64_t key, bool fin) {
  epoll_event event{};
  // A hang-up and an error are always reported. One shot: the state stays, and a level that stays
  // would spin.
  event.events = EPOLLONESHOT | (fin ? EPOLLRDHUP : 0U);
  event.data.u64 = key;
  if (::epoll_ctl(epoll_.native_handle(), EPOLL_CTL_MOD, socket, &event) == 0) {
    return true;
  }
  return errno == ENOENT && ::epoll_ctl(epoll_.native_handle(), EPOLL_CTL_ADD, socket, &event) == 0;
}

void HangupWatch::forget(int socket) {
  epoll_event ignored{};
  ::epoll_ctl(epoll_.native_handle(), EPOLL_CTL_DEL, socket, &ignored);
}

boost::asio::awaitable<void> HangupWatch::run() {
  while (true) {
    const auto [error] =
        co_await epoll_.async_wait(boost::asio::posix::descriptor_base::wait_read, kAsTuple);
    if (error) {
      co_return;
    }
    report_all();
  }
}

void HangupWatch::report_all() {
  std::array<epoll_event, kEventsAtOnce> events{};
  const int count = ::epoll_wait(epoll_.native_handle(), events.data(), events.size(), 0);
  if (count <= 0) {
    return;
  }
  for (const epoll_event& event : std::span(events).first(static_cast<std::size_t>(count))) {
    const bool reset = (event.events & (EPOLLHUP | EPOLLERR)) != 0;
    callback_(event.data.u64, reset ? Hangup::reset : Hangup::fin);
  }
}

}  // namespace mbgate::io

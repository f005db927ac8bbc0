// SPDX-License-Identifier: Apache-2.0
#include "io/clock.hpp"

#include <sys/timerfd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <ctime>
#include <system_error>
#include <utility>

#include "sys/unique_fd.hpp"

namespace mbgate::io {
namespace {

int make_timer() {
  const int timer = ::timerfd_create(CLOCK_BOOTTIME, TFD_NONBLOCK | TFD_CLOEXEC);
  if (timer < 0) {
    throw std::system_error(errno, std::generic_category(), "timerfd_create");
  }
  return timer;
}

}  // namespace

BootTimer::BootTimer(boost::asio::io_context& context, std::function<void()> on_ring)
    : timer_(context, make_timer()), on_ring_(std::move(on_ring)) {}

void BootTimer::set(bus::Duration after) {
  // 0 would disarm it.
  const itimerspec to{{}, sys::timespec_of(std::max(after, bus::Duration(1)))};
  ::timerfd_settime(timer_.native_handle(), 0, &to, nullptr);
  if (!std::exchange(waits_, true)) {
    wait();
  }
}

// What was read of it is of no use: it is set anew before it is waited for again.
void BootTimer::wait() {
  timer_.async_wait(boost::asio::posix::descriptor_base::wait_read,
                    [this](const boost::system::error_code& error) {
                      if (error) {
                        return;
                      }
                      waits_ = false;
                      on_ring_();
                    });
}

}  // namespace mbgate::io

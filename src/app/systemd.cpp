// SPDX-License-Identifier: Apache-2.0
#include "app/systemd.hpp"

#include <systemd/sd-daemon.h>

#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <utility>

namespace mbgate::app {
namespace {

/// Memory of a C library, which free() gives back.
template <typename Value>
using Allocated = std::unique_ptr<Value, void (*)(void*)>;

/// Part of the limit after which a gateway that was not well is looked at again. After a process
/// was stopped and continued, this may be called before the driver that catches up: that must not
/// cost half of the limit.
constexpr int kLooksAgain = 10;

}  // namespace

std::vector<InheritedSocket> take_inherited_sockets() {
  std::vector<InheritedSocket> sockets;
  char** list = nullptr;
  const int count = ::sd_listen_fds_with_names(1, &list);
  const Allocated<char*> names(list, &std::free);
  for (int i = 0; i < count; ++i) {
    const Allocated<char> name(names.get()[i], &std::free);
    sockets.push_back({name.get(), sys::UniqueFd(SD_LISTEN_FDS_START + i)});
  }
  return sockets;
}

void notify_ready(const std::string& status) {
  ::sd_notify(0, ("READY=1\nSTATUS=" + status).c_str());
}

void notify_status(const std::string& status) { ::sd_notify(0, ("STATUS=" + status).c_str()); }

void notify_reloading() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  constexpr long kMicrosecond = 1000;
  constexpr long kSecond = 1'000'000;
  ::sd_notifyf(0, "RELOADING=1\nMONOTONIC_USEC=%lld\nSTATUS=reading the configuration",
               static_cast<long long>(now.tv_sec) * kSecond + now.tv_nsec / kMicrosecond);
}

void notify_stopping() { ::sd_notify(0, "STOPPING=1\nSTATUS=stopping"); }

std::optional<std::chrono::microseconds> watchdog_limit() {
  std::uint64_t microseconds = 0;
  if (::sd_watchdog_enabled(0, &microseconds) <= 0) {
    return std::nullopt;
  }
  return std::chrono::microseconds(microseconds);
}

void notify_alive() { ::sd_notify(0, "WATCHDOG=1"); }

// Without FDPOLL=0: systemd then lets go by itself of a socket that was shut down, and one that
// listens never hangs up.
bool store_socket(const std::string& name, int socket) {
  const std::string text = "FDSTORE=1\nFDNAME=" + name;
  return ::sd_pid_notify_with_fds(0, 0, text.c_str(), &socket, 1) > 0;
}

void remove_stored_socket(const std::string& name) {
  ::sd_notify(0, ("FDSTOREREMOVE=1\nFDNAME=" + name).c_str());
}

Watchdog::Watchdog(boost::asio::io_context& context, std::function<bool()> is_well,
                   std::function<void()> feed)
    : timer_(context), is_well_(std::move(is_well)), feed_(std::move(feed)) {}

void Watchdog::start(std::chrono::microseconds limit) {
  limit_ = limit;
  look();
}

void Watchdog::look() {
  const bool is_well = is_well_();
  if (is_well) {
    feed_();
  }
  timer_.expires_after(is_well ? limit_ / 2 : limit_ / kLooksAgain);
  timer_.async_wait([this](const boost::system::error_code& error) {
    if (!error) {
      look();
    }
  });
}

}  // namespace mbgate::app

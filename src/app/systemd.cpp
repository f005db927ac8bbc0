// SPDX-License-Identifier: Apache-2.0
#include "app/systemd.hpp"

#include <fcntl.h>
#include <systemd/sd-daemon.h>

#include <atomic>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <fmt/core.h>
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

/// Sends what systemd is told, in order, from a thread of its own: sendmsg() blocks as long as
/// nobody reads the socket (a systemd that reloads its units, or has crashed), and the lines must
/// not wait for that. Never destroyed, as the thread may hang in it when the process ends.
class Notifier {
 public:
  /// False: there is no systemd. Dropped where `most` wait. `socket`: it gets a duplicate.
  bool send(std::string text, int most, std::optional<int> socket) {
    if (std::getenv("NOTIFY_SOCKET") == nullptr) {
      return false;
    }
    if (waiting_ < most) {
      ++waiting_;
      const auto copy =
          std::make_shared<sys::UniqueFd>(socket ? ::fcntl(*socket, F_DUPFD_CLOEXEC, 0) : -1);
      boost::asio::post(writer_, [this, text = std::move(text), copy] {
        const int descriptor = copy->get();
        ::sd_pid_notify_with_fds(0, 0, text.c_str(), &descriptor, copy->is_open() ? 1 : 0);
        --waiting_;
      });
    }
    return true;
  }

 private:
  std::atomic<int> waiting_ = 0;
  boost::asio::thread_pool writer_{1};
};

constexpr int kMostMessages = 100;
/// Of those that come again and again: they must not take the place of READY=1.
constexpr int kMostRepeated = 10;

bool notify(std::string text, int most = kMostMessages, std::optional<int> socket = std::nullopt) {
  static auto& notifier = *new Notifier;  // NOLINT(cppcoreguidelines-owning-memory)
  return notifier.send(std::move(text), most, socket);
}

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

void notify_ready(const std::string& status) { notify("READY=1\nSTATUS=" + status); }

void notify_status(const std::string& status) { notify("STATUS=" + status, kMostRepeated); }

void notify_reloading() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  constexpr long kMicrosecond = 1000;
  constexpr long kSecond = 1'000'000;
  notify(fmt::format("RELOADING=1\nMONOTONIC_USEC={}\nSTATUS=reading the configuration",
                     now.tv_sec * kSecond + now.tv_nsec / kMicrosecond));
}

void notify_stopping() { notify("STOPPING=1\nSTATUS=stopping"); }

std::optional<std::chrono::microseconds> watchdog_limit() {
  std::uint64_t microseconds = 0;
  if (::sd_watchdog_enabled(0, &microseconds) <= 0) {
    return std::nullopt;
  }
  return std::chrono::microseconds(microseconds);
}

void notify_alive() { notify("WATCHDOG=1", kMostRepeated); }

// Without FDPOLL=0: systemd then lets go by itself of a socket that was shut down, and one that
// listens never hangs up.
bool store_socket(const std::string& name, int socket) {
  return notify("FDSTORE=1\nFDNAME=" + name, kMostMessages, socket);
}

void remove_stored_socket(const std::string& name) { notify("FDSTOREREMOVE=1\nFDNAME=" + name); }

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

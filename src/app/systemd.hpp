// SPDX-License-Identifier: Apache-2.0
// What systemd hands to the process and what the process reports to it. Without systemd all of this
// does nothing.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sys/unique_fd.hpp"

namespace mbgate::app {

/// A socket of a .socket unit, or one that store_socket() was given; `name` is its
/// FileDescriptorName=, or the name it was stored with.
struct InheritedSocket {
  std::string name;
  sys::UniqueFd fd;
};

/// Takes over the sockets, once.
std::vector<InheritedSocket> take_inherited_sockets();

void notify_ready(const std::string& status);
void notify_status(const std::string& status);
void notify_stopping();
/// A reload has begun; notify_ready() reports its end.
void notify_reloading();

/// WatchdogSec= of the unit: systemd takes the process for hung when notify_alive() was not called
/// for so long. Nothing: nobody watches.
std::optional<std::chrono::microseconds> watchdog_limit();
void notify_alive();

/// systemd keeps this socket too, and hands it to the next process of the unit
/// (FileDescriptorStoreMax=). `name`: at most 255 letters of ASCII without ':'. A socket that it
/// has already is not kept twice. False: there is no systemd.
bool store_socket(const std::string& name, int socket);
/// systemd closes its copies of the sockets of this name.
void remove_stored_socket(const std::string& name);

/// Tells systemd again and again that the gateway is well, from the thread that runs it. A gateway
/// that hangs says nothing, and neither does one that misses its deadlines: systemd then ends it
/// and starts another one.
class Watchdog {
 public:
  /// `is_well` is asked before each `feed`.
  Watchdog(boost::asio::io_context& context, std::function<bool()> is_well,
           std::function<void()> feed);
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;
  ~Watchdog() = default;

  /// Feeds now, and then every half of `limit`, until the io_context ends.
  void start(std::chrono::microseconds limit);

 private:
  void look();

  boost::asio::steady_timer timer_;
  std::function<bool()> is_well_;
  std::function<void()> feed_;
  std::chrono::microseconds limit_{0};
};

}  // namespace mbgate::app

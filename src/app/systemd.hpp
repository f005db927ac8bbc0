// SPDX-License-Identifier: Apache-2.0
// What systemd hands to the process and what the process reports to it. Without systemd all of this
// does nothing.
#pragma once

#include <chrono>
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

}  // namespace mbgate::app

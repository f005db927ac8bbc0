// SPDX-License-Identifier: Apache-2.0
#include "io/clients/resources.hpp"

#include <sys/mman.h>
#include <sys/resource.h>

#include <algorithm>
#include <fmt/core.h>
#include <limits>

#include "gateway/settings.hpp"

namespace mbgate::io {
namespace {

/// What a line may need at a time: one descriptor that is being opened and one that is still being
/// closed, or those with which a name is looked up.
constexpr std::size_t kForEachLine = 4;
/// Files that are open for a moment.
constexpr std::size_t kForFiles = 32;
/// The process has these before the first client comes: its standard streams, timers, signals, the
/// recording.
constexpr std::size_t kOfTheProcess = 16;
/// The socket that listens, a copy of it for when it has to end, and a spare one.
constexpr std::size_t kForEachListener = 3;
/// Its socket, and the two ends of the pair by which the machine has it.
constexpr std::size_t kForEachTlsClient = 3;
/// Free for those who are served.
constexpr std::size_t kMemoryLeft = 8'388'608;
/// The socket that listens, and a copy of it.
constexpr std::size_t kForEachHttpSocket = 2;

std::size_t reserved(const gateway::Settings& settings) {
  return kForEachLine * gateway::count_there(settings.buses) + kForFiles;
}

/// What the HTTP interface may have at most: the sockets that listen, connections, and those that
/// follow something.
std::size_t of_http(const gateway::Settings& settings, std::size_t inherited) {
  const std::size_t tcp =
      inherited > 0 ? inherited : kForEachHttpSocket * settings.http.listen.size();
  const std::size_t sockets = tcp + (settings.control_socket.empty() ? 0 : 1);
  const std::size_t kinds = (tcp > 0 ? 1 : 0) + (settings.control_socket.empty() ? 0 : 1);
  return kinds == 0 ? 0 : sockets + kinds * gateway::kHttpConnections + settings.http.max_streams;
}

std::size_t descriptors_of_clients(const gateway::ListenerSettings& listener) {
  if (listener.is_gone) {
    return 0;
  }
  return listener.tls ? kForEachTlsClient * listener.max_connections + listener.handshakes.at_a_time
                      : listener.max_connections;
}

std::size_t descriptors_of(rlim_t limit) {
  // RLIM_INFINITY among them: no descriptor is larger than an int.
  return static_cast<std::size_t>(
      std::min(limit, static_cast<rlim_t>(std::numeric_limits<int>::max())));
}

}  // namespace

std::size_t raise_descriptor_limit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) {
    return 0;
  }
  const rlim_t before = limit.rlim_cur;
  limit.rlim_cur = limit.rlim_max;
  return descriptors_of(::setrlimit(RLIMIT_NOFILE, &limit) == 0 ? limit.rlim_max : before);
}

std::size_t hard_descriptor_limit() {
  rlimit limit{};
  return ::getrlimit(RLIMIT_NOFILE, &limit) == 0 ? descriptors_of(limit.rlim_max) : 0;
}

DescriptorRoom room_for_clients(const gateway::Settings& settings, std::size_t limit,
                                std::size_t http_sockets) {
  const std::size_t others = reserved(settings) + kOfTheProcess +
                             kForEachListener * gateway::count_there(settings.listeners);
  std::size_t wanted = 0;
  for (const auto& listener : settings.listeners) {
    wanted += descriptors_of_clients(listener);
  }
  DescriptorRoom room;
  room.clients = limit > others ? limit - others : 0;
  const std::size_t http = of_http(settings, http_sockets);
  if (room.clients >= wanted + http) {
    return room;
  }
  const bool has_tls = std::ranges::any_of(
      settings.listeners, [](const auto& it) { return !it.is_gone && it.tls.has_value(); });
  room.shortage = fmt::format(
      "max_connections of all listeners together is {}{}{}, but the limit of {} open files leaves "
      "room for {} clients: lower {}, or raise the limit (LimitNOFILE= of the unit) to {}",
      wanted, has_tls ? " (with TLS each counts three times, and each of max_handshakes once)" : "",
      http > 0 ? fmt::format(", the HTTP interface may need {} more", http) : "", limit,
      room.clients, http > 0 ? "max_connections or [http] max_streams" : "it",
      wanted + http + others);
  return room;
}

// Not from the heap, which would keep it. It takes no page of memory.
bool is_memory_left() {
  void* const mapped =
      ::mmap(nullptr, kMemoryLeft, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  return mapped != MAP_FAILED && ::munmap(mapped, kMemoryLeft) == 0;
}

int end_of_client_descriptors(const gateway::Settings& settings) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) {
    return std::numeric_limits<int>::max();
  }
  const std::size_t all = descriptors_of(limit.rlim_cur);
  return static_cast<int>(all - std::min(all, reserved(settings)));
}

}  // namespace mbgate::io

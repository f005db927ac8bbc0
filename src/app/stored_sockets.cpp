// SPDX-License-Identifier: Apache-2.0
#include "app/stored_sockets.hpp"

#include <fcntl.h>
#include <sys/socket.h>

#include <algorithm>
#include <fmt/core.h>
#include <string_view>
#include <utility>

#include "io/clients/listening_socket.hpp"

namespace mbgate::app {
namespace {

using boost::asio::ip::tcp;
using gateway::ListenerSettings;

constexpr std::string_view kPrefix = "stored/";

/// The name under which a socket of this listener is stored; empty if none is.
std::string stored_name_of(const ListenerSettings& listener) {
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(listener.address, error);
  const bool is_stored = !error && listener.port != 0 && !listener.is_gone;
  return is_stored ? stored_name(listener.name, {address, listener.port}) : std::string();
}

bool is_wanted(const std::string& name, int socket,
               const std::vector<ListenerSettings>& listeners) {
  return std::ranges::any_of(listeners, [&](const ListenerSettings& listener) {
    return stored_name_of(listener) == name && io::is_bound_for(listener, socket);
  });
}

}  // namespace

// What such a name may not have, and '%', is written as two hexadecimal digits (sd_notify(3)).
std::string stored_name(const std::string& listener, const tcp::endpoint& at) {
  std::string name(kPrefix);
  for (const char c : listener + '/' + io::to_text(at)) {
    const auto code = static_cast<unsigned char>(c);
    if (c > ' ' && c <= '~' && c != ':' && c != '%') {
      name += c;
    } else {
      name += fmt::format("%{:02X}", code);
    }
  }
  return name;
}

StoredSockets::StoredSockets(Store store, Remove remove)
    : store_(std::move(store)), remove_(std::move(remove)) {}

void StoredSockets::take(std::vector<InheritedSocket>& inherited,
                         const std::vector<ListenerSettings>& listeners) {
  for (auto& [name, fd] : inherited) {
    if (!name.starts_with(kPrefix)) {
      continue;
    }
    sys::UniqueFd socket = std::move(fd);
    if (is_wanted(name, socket.get(), listeners)) {
      found_.emplace(name, std::move(socket));  // or it is another copy of the same one
    } else {
      end(name, socket);
    }
  }
  std::erase_if(inherited, [](const InheritedSocket& it) { return it.name.starts_with(kPrefix); });
}

sys::UniqueFd StoredSockets::claim(const ListenerSettings& listener) {
  auto entry = found_.extract(stored_name_of(listener));
  return entry ? std::move(entry.mapped()) : sys::UniqueFd();
}

void StoredSockets::end_unclaimed() {
  for (const auto& [name, socket] : found_) {
    end(name, socket);
  }
  found_.clear();
}

void StoredSockets::keep(const ListenerSettings& listener, tcp::acceptor& acceptor) {
  const std::string name = stored_name_of(listener);
  const int socket = acceptor.native_handle();
  if (!name.empty() && store_(name, socket)) {
    kept_.insert_or_assign(name, sys::UniqueFd(::fcntl(socket, F_DUPFD_CLOEXEC, 0)));
  }
}

void StoredSockets::end(const ListenerSettings& listener) {
  if (const auto entry = kept_.extract(stored_name_of(listener))) {
    end(entry.key(), entry.mapped());
  }
}

// systemd has a copy until it has read this. To shut the socket down ends the listening of all
// copies: the address can be bound at once, and nobody waits where nobody will come.
void StoredSockets::end(const std::string& name, const sys::UniqueFd& socket) {
  ::shutdown(socket.get(), SHUT_RDWR);
  remove_(name);
}

}  // namespace mbgate::app

// SPDX-License-Identifier: Apache-2.0
// The listening sockets that systemd keeps while this process ends and the next one starts, so that
// a client that connects meanwhile waits and is served. Sockets of .socket units are not among
// them: systemd keeps those anyway.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "app/systemd.hpp"
#include "gateway/settings.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::app {

/// "stored/plant/127.0.0.1%3A502": no .socket unit should have such a FileDescriptorName=. There is
/// one for each address, because systemd lets go of all sockets of a name.
std::string stored_name(const std::string& listener, const boost::asio::ip::tcp::endpoint& at);

class StoredSockets {
 public:
  /// store_socket(), or a test's replacement for it.
  using Store = std::function<bool(const std::string& name, int socket)>;
  /// remove_stored_socket(), or a test's replacement for it.
  using Remove = std::function<void(const std::string& name)>;

  explicit StoredSockets(Store store = store_socket, Remove remove = remove_stored_socket);

  /// Takes those that an earlier process has stored out of `inherited`. What none of these
  /// listeners has any more, by name and address, is ended, so that its address can be bound.
  void take(std::vector<InheritedSocket>& inherited,
            const std::vector<gateway::ListenerSettings>& listeners);
  /// The one that an earlier process has bound for this listener; else none.
  [[nodiscard]] sys::UniqueFd claim(const gateway::ListenerSettings& listener);
  /// Nobody claims any more: ends the others.
  void end_unclaimed();

  /// From now on systemd keeps this socket. Not if the kernel chooses the port: the next process
  /// may have another one.
  void keep(const gateway::ListenerSettings& listener, boost::asio::ip::tcp::acceptor& acceptor);
  /// The listener has left its address. Nobody listens there any more, from this moment on.
  void end(const gateway::ListenerSettings& listener);
  /// The process ends: what is kept is for the next one.
  void let_go() { kept_.clear(); }

 private:
  using Sockets = std::map<std::string, sys::UniqueFd>;
  void end(const std::string& name, const sys::UniqueFd& socket);

  Store store_;
  Remove remove_;
  Sockets found_;  ///< of an earlier process, not claimed yet
  Sockets kept_;   ///< of this process; a copy of each
};

}  // namespace mbgate::app

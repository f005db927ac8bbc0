// SPDX-License-Identifier: Apache-2.0
// A TCP socket that listens for one listener of the settings. It was bound by us, or bound by
// systemd and handed over. Its options are also those of every connection accepted from it, because
// on Linux an accepted socket inherits them.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <map>
#include <string>
#include <vector>

#include "gateway/settings.hpp"
#include "modbus/result.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::io {

struct ListenFailure {
  std::string why;      ///< one line with the listener's name and its address
  bool absent = false;  ///< this machine does not have the address (yet)
  bool denied = false;  ///< not permitted, now or later
};

/// Binds the listener's address and port.
Result<boost::asio::ip::tcp::acceptor, ListenFailure> bind_listener(
    boost::asio::io_context& context, const gateway::ListenerSettings& listener);

/// Takes over a listening TCP socket; address and port of the settings are then not used.
Result<boost::asio::ip::tcp::acceptor, ListenFailure> adopt_listener(
    boost::asio::io_context& context, const gateway::ListenerSettings& listener,
    sys::UniqueFd socket);

/// A socket that listens at just the address and port of the settings, as bind_listener() makes it:
/// all of its other options can still be changed.
bool is_bound_for(const gateway::ListenerSettings& listener, int socket);

/// "127.0.0.1:502" or "[::1]:502"
std::string to_text(const boost::asio::ip::tcp::endpoint& endpoint);

// A socket unit of systemd takes the place of a listener's address, so the configuration alone does
// not say whether other machines reach it. Drives are not opened to whole networks by a socket unit
// any more than by one line of the configuration.

/// The listening sockets that systemd has handed over.
struct SystemdSockets {
  /// Where other machines reach a socket of that name, such as "[::]:502".
  std::map<std::string, std::string> reached;

  /// `socket`: its descriptor, which stays the caller's.
  void add(const std::string& name, int socket);
  /// They are closed: a listener of that name has its own address from now on.
  void drop(const std::string& name);
};

/// One line for each listener that lets everyone in there: neither `allow` nor a rule says who may
/// connect. Such a configuration is refused, as with an address that other machines reach.
std::vector<std::string> open_listeners(const gateway::Settings& settings,
                                        const SystemdSockets& sockets);

}  // namespace mbgate::io

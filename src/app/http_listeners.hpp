// SPDX-License-Identifier: Apache-2.0
// The TCP sockets of the HTTP interface: the addresses of `[http] listen`, or in their place the
// sockets named "http" that systemd hands over. The gateway serves drives without them; an address
// that cannot be bound is tried again.
#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>
#include <vector>

#include "app/control/control.hpp"
#include "app/listeners.hpp"
#include "app/log.hpp"
#include "gateway/settings.hpp"

namespace mbgate::app {

/// `listen` as listeners. Those of `old` keep their numbers, and are marked where they have gone.
std::vector<gateway::ListenerSettings> http_listeners(std::vector<gateway::ListenerSettings> old,
                                                      const gateway::HttpSettings& settings);

class HttpListeners {
 public:
  HttpListeners(boost::asio::io_context& context, Log& log, Control& control);

  /// As Listeners.
  void use(StoredSockets& stored) { listeners_.use(stored); }
  /// Takes its sockets out of those from systemd, if no listener has that name.
  void take(const gateway::Settings& settings, std::vector<InheritedSocket>& inherited);
  /// How many that took.
  [[nodiscard]] std::size_t inherited() const { return inherited_.size(); }
  void begin(const gateway::HttpSettings& settings);
  /// As Listeners: prints "listening http ADDRESS:PORT", and tries again.
  void start() { listeners_.start(); }
  /// Before a reload: closes the sockets that these settings do not have, and calls `then` when a
  /// listener of another kind can have their addresses, perhaps at once. Their connections stay,
  /// and reload() with the settings in force takes all of it back. Where the kernel chose the port,
  /// it could not be taken back, and nobody else asks for it: such a socket stays until reload().
  void make_room(const gateway::HttpSettings& settings, const std::function<void()>& then);
  /// After make_room(), if these are other settings: puts them into force. Connections at addresses
  /// that they do not have, or of clients that may not read any more, are closed. Sockets from
  /// systemd stay as they are.
  void reload(const gateway::HttpSettings& settings);
  void stop();

 private:
  void change(const std::vector<gateway::ListenerSettings>& next);

  Log& log_;
  Control& control_;
  Listeners listeners_;
  std::vector<gateway::ListenerSettings> now_;
  std::vector<InheritedSocket> inherited_;  ///< until begin()
  bool is_inherited_ = false;
  bool has_stopped_ = false;
};

}  // namespace mbgate::app

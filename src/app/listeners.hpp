// SPDX-License-Identifier: Apache-2.0
// The listening sockets of the service: those that systemd hands over, and those that we bind. A
// listener whose address does not exist yet (boot, DHCP, VRRP) is tried again while the others
// serve.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "app/log.hpp"
#include "app/stored_sockets.hpp"
#include "app/systemd.hpp"
#include "gateway/settings.hpp"
#include "io/clients/listening_socket.hpp"

namespace mbgate::app {

/// The wait between two tries. It doubles from the first to the longest.
struct ListenerWaits {
  std::chrono::milliseconds first{250};
  std::chrono::milliseconds longest{5000};
  /// What the journal says of it.
  const char* promise =
      "it is tried again until this machine has the address (freebind = true listens at once)";
};

class Listeners {
 public:
  using Acceptor = boost::asio::ip::tcp::acceptor;
  /// io::bind_listener(), or a test's replacement for it.
  using Bind = std::function<Result<Acceptor, io::ListenFailure>(boost::asio::io_context&,
                                                                 const gateway::ListenerSettings&)>;
  /// Called with every listening socket, at once or later.
  using Take = std::function<void(gateway::ListenerId, Acceptor)>;
  /// Closes the sockets of a listener.
  using Drop = std::function<void(gateway::ListenerId)>;

  Listeners(boost::asio::io_context& context, Log& log, Take take, Bind bind = io::bind_listener,
            ListenerWaits waits = {});
  Listeners(const Listeners&) = delete;
  Listeners& operator=(const Listeners&) = delete;
  ~Listeners() = default;

  /// Before begin(): the sockets that we bind are kept there, and are taken from there again.
  void use(StoredSockets& stored) { stored_ = &stored; }
  /// Makes every listener listen, or wait for its address. False: a listener can do neither (its
  /// port is in use or not permitted), and the journal says why.
  bool begin(const std::vector<gateway::ListenerSettings>& listeners,
             std::vector<InheritedSocket> inherited);
  /// Prints "listening NAME ADDRESS:PORT" for each socket. Listeners that wait are tried again, and
  /// their lines are printed when they listen.
  void start();
  /// After start(): applies the differences between these settings, which have the same numbering.
  /// Sockets are closed if their listener is removed, has another address or has other TCP options;
  /// sockets from systemd stay open. New and changed listeners listen, or wait for their address.
  /// False: one can do neither, the journal says why, and nothing has changed.
  bool reload(const std::vector<gateway::ListenerSettings>& old,
              const std::vector<gateway::ListenerSettings>& next, const Drop& drop);
  /// Why the last reload() could not be applied, for whoever asked for it.
  [[nodiscard]] const std::vector<std::string>& refusals() const { return refusals_; }
  void stop();
  /// A listener was not permitted: trying again does not help.
  [[nodiscard]] bool is_denied() const { return is_denied_; }
  /// How many listeners wait for their address.
  [[nodiscard]] std::size_t waiting() const { return waiting_.size(); }

 private:
  using Bound = Result<Acceptor, io::ListenFailure>;
  struct Waiting {
    gateway::ListenerId id;
    gateway::ListenerSettings listener;
    std::string said;  ///< in the journal already
  };
  struct Line {
    std::string text;
    Topic topic;
  };

  bool listen(gateway::ListenerId id, const gateway::ListenerSettings& listener,
              std::vector<InheritedSocket>& inherited);
  bool keep(gateway::ListenerId id, const gateway::ListenerSettings& listener,
            Result<Acceptor, io::ListenFailure> acceptor);
  void refuse(const gateway::ListenerSettings& listener, const io::ListenFailure& failure);
  void add(gateway::ListenerId id, const gateway::ListenerSettings& listener, Acceptor acceptor);
  void leave(gateway::ListenerId id, const gateway::ListenerSettings& listener, const Drop& drop);
  bool open_all(const std::vector<std::size_t>& wanted,
                const std::vector<gateway::ListenerSettings>& settings);
  [[nodiscard]] bool stays(gateway::ListenerId id, const gateway::ListenerSettings& old,
                           const gateway::ListenerSettings& next) const;
  /// Does it listen now?
  bool try_again(Waiting& waiting);
  void keep_trying();
  boost::asio::awaitable<void> try_on();

  boost::asio::io_context& context_;
  Log& log_;
  Take take_;
  Bind bind_;
  ListenerWaits waits_;
  boost::asio::steady_timer timer_;
  StoredSockets* stored_ = nullptr;
  bool started_ = false;
  std::vector<Line> lines_;  ///< to be printed by start()
  std::vector<Waiting> waiting_;
  bool trying_ = false;
  bool is_denied_ = false;
  std::vector<std::string> refusals_;
  std::set<gateway::ListenerId> inherited_;  ///< their sockets are systemd's
};

}  // namespace mbgate::app

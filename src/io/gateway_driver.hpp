// SPDX-License-Identifier: Apache-2.0
// Attaches real sockets, serial lines and the clock to the machine: every input is handed over with
// the time of its arrival, then all actions are carried out and the one timer is set. Nothing is
// decided here.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gateway/action.hpp"
#include "gateway/gateway.hpp"
#include "gateway/input.hpp"
#include "io/blocking_calls.hpp"
#include "io/clients/client_connections.hpp"
#include "io/clients/server_set.hpp"
#include "io/lines/line_set.hpp"
#include "io/recorder.hpp"

namespace mbgate::io {

/// What the process around the driver wants to know.
class DriverObserver {
 public:
  virtual ~DriverObserver() = default;
  virtual void on_event(const gateway::Event& event) = 0;
  virtual void on_line_warning(gateway::BusId bus, const std::string& warning) = 0;
  /// A line could not be opened, or died. Comes at each try.
  virtual void on_line_failure(gateway::BusId bus, const std::string& why) = 0;
  virtual void on_accept_failure(gateway::ListenerId listener, const std::string& why) = 0;
  /// What status() says may have changed.
  virtual void on_status_changed() = 0;
  /// After shutdown(): everything is answered, and the clients have it.
  virtual void on_finished() = 0;
};

class GatewayDriver final : public AcceptEvents, public ConnectionEvents, public LineEvents {
 public:
  /// Everything that goes into the machine and comes out of it is noted in the recorder, if there
  /// is one.
  GatewayDriver(boost::asio::io_context& context, gateway::Settings settings,
                DriverObserver& observer, Recorder* recorder = nullptr);
  GatewayDriver(const GatewayDriver&) = delete;
  GatewayDriver& operator=(const GatewayDriver&) = delete;
  ~GatewayDriver() override = default;

  /// Before start(), or later; then it accepts at once. One listener may have several sockets.
  void add_server(gateway::ListenerId listener, boost::asio::ip::tcp::acceptor acceptor);
  /// Begins to open the lines and accepts what is already waiting, as older than this process. On
  /// return the gateway is ready.
  void start();
  /// Other settings from now on (gateway::SettingsChanged), read from `config`. Sockets of
  /// listeners that are no more are closed; new ones come by add_server().
  void reload(const gateway::Settings& settings, std::string_view config);
  /// Nobody is accepted any more on the sockets of this listener.
  void remove_servers(gateway::ListenerId listener);
  /// Accepts no more, lets the machine finish, and ends in on_finished().
  void shutdown();

  [[nodiscard]] gateway::Status status() const { return gateway_.status(); }
  [[nodiscard]] const gateway::Settings& settings() const { return gateway_.settings(); }

 private:
  void client_accepted(gateway::ListenerId listener, AcceptedClient client) override;
  void accept_failed(gateway::ListenerId listener, const boost::system::error_code& error) override;
  void client_bytes(gateway::ClientId client, modbus::Bytes bytes, std::size_t unread) override;
  void client_sent(gateway::ClientId client) override;
  void client_half_closed(gateway::ClientId client) override;
  void client_disconnected(gateway::ClientId client) override;
  void client_closed(gateway::ClientId client) override;
  void line_opened(gateway::BusId bus, bus::LineKind kind,
                   const std::vector<std::string>& warnings) override;
  void line_bytes(gateway::BusId bus, modbus::Bytes bytes) override;
  void line_lost(gateway::BusId bus, const std::string& why) override;
  void line_closed(gateway::BusId bus, const std::string& why) override;

  /// The one way into the machine: what passes here, and nothing else, is what a recording has.
  void feed(const gateway::Input& input);
  /// Carries out what the machine wants until it wants nothing more, then sets the timer. A call
  /// from within, by an action that has an input as its consequence, leaves the work to the outer
  /// one.
  void carry_out_actions();
  void set_timer();
  void wait_for_end_of_silence(const gateway::Wake& wake);
  /// Reads what lies in the lines, then lets the machine judge.
  void handle_wake();
  void carry_out(const gateway::Send& action);
  void carry_out(const gateway::Pause& action);
  void carry_out(const gateway::Resume& action);
  void carry_out(const gateway::Close& action);
  void carry_out(const gateway::Open& action);
  void carry_out(const gateway::Look& action);
  void carry_out(const gateway::Transmit& action);
  void carry_out(const gateway::Shut& action);
  void carry_out(const gateway::Report& action);
  void carry_out(const gateway::Finished& action);
  void drop(gateway::ClientId client);
  void finish();

  boost::asio::io_context& context_;
  DriverObserver& observer_;
  Recorder* recorder_;
  gateway::Instant started_;
  gateway::Gateway gateway_;
  bool carrying_out_ = false;
  boost::asio::steady_timer timer_;
  std::optional<gateway::Instant> timer_set_to_;
  /// Bytes that lay in the lines at one instant are handed in with it, before what it judges.
  std::optional<gateway::Instant> reading_at_;
  BlockingCalls blocking_;
  ClientConnections clients_;
  LineSet lines_;
  ServerSet servers_;
  enum class Phase : std::uint8_t { starting, serving, flushing, finished };
  Phase phase_ = Phase::starting;
  boost::asio::steady_timer flush_timer_;
};

}  // namespace mbgate::io

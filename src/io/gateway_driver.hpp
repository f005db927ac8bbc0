// SPDX-License-Identifier: Apache-2.0
// Attaches real sockets, serial lines and the clock to the machine. Every input is handed over with
// its time of arrival; then all actions are carried out and the single timer is set. The driver
// decides nothing.
//
// To change
// - when the driver wakes for a deadline (wake_early): gateway_driver.
// - how the driver notices that the process did not run, and which input is old then: heartbeat,
//   GatewayDriver::notice_stall(); in the machine: Stalled, ClientSession::stall().
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
#include "io/clients/tcp_server.hpp"
#include "io/clock.hpp"
#include "io/heartbeat.hpp"
#include "io/lines/line.hpp"
#include "io/recorder.hpp"
#include "io/tls/tls_door.hpp"

namespace mbgate::io {

/// What the driver reports to the process around it.
class DriverObserver {
 public:
  virtual ~DriverObserver() = default;
  virtual void on_event(const gateway::Event& event) = 0;
  virtual void on_line_warning(gateway::BusId bus, const std::string& warning) = 0;
  /// A line could not be opened, or was lost. Called for each attempt.
  virtual void on_line_failure(gateway::BusId bus, const std::string& why) = 0;
  virtual void on_accept_failure(gateway::ListenerId listener, const std::string& why) = 0;
  /// A client has no handshake of TLS, or its certificate is not accepted any more.
  virtual void on_tls_refusal(const TlsPlace& place, const std::string& why) = 0;
  /// The io thread has not run for so long.
  virtual void on_stall(std::chrono::milliseconds lasted) = 0;
  /// The result of status() may have changed.
  virtual void on_status_changed() = 0;
  /// After shutdown(): everything is answered, and the answers are sent.
  virtual void on_finished() = 0;
};

class GatewayDriver final : public AcceptEvents,
                            public ConnectionEvents,
                            public LineEvents,
                            public TlsEvents {
 public:
  /// All inputs and actions of the machine are noted in the recorder, if there is one.
  GatewayDriver(boost::asio::io_context& context, gateway::Settings settings,
                DriverObserver& observer, Recorder* recorder = nullptr, Clock clock = now);
  GatewayDriver(const GatewayDriver&) = delete;
  GatewayDriver& operator=(const GatewayDriver&) = delete;
  ~GatewayDriver() override = default;

  /// May be called before start(), or later; then the socket accepts at once. One listener may have
  /// several sockets.
  void add_server(gateway::ListenerId listener, boost::asio::ip::tcp::acceptor acceptor);
  /// Begins to open the lines, and accepts the connections that are already waiting; these count as
  /// older than this process. On return the gateway is ready.
  void start();
  /// New settings from now on (gateway::SettingsChanged, `config` too). Sockets of removed
  /// listeners are closed; new ones are added by add_server().
  void reload(const gateway::Settings& settings, std::string_view config);
  /// Closes the sockets of this listener: no more clients are accepted on them.
  void remove_servers(gateway::ListenerId listener) { servers_.remove(listener); }
  /// Certificates of the listeners with TLS, from now on; before start() too.
  void use_tls(const TlsContexts& contexts, const gateway::Settings& next);
  void clear_counters() { process(gateway::ClearCountersAsked{}); }
  /// Accepts no more clients and lets the machine finish; on_finished() follows.
  void shutdown();

  [[nodiscard]] gateway::Status status() const { return gateway_.status(); }
  [[nodiscard]] gateway::StatusReport report_status(bool with_clients) const;
  [[nodiscard]] bool meets_deadlines() const { return gateway_.meets_deadlines(clock_()); }
  void set_traced(bool traced) { gateway_.set_traced(traced); }
  gateway::TraceBook::Taken take_trace() { return gateway_.take_trace(clock_()); }
  [[nodiscard]] const gateway::Settings& settings() const { return gateway_.settings(); }

 private:
  void client_accepted(gateway::ListenerId listener, AcceptedClient client) override;
  void accept_failed(gateway::ListenerId listener, const boost::system::error_code& error) override;
  void tls_arrived(TlsArrival arrival) override;
  void tls_refused(const TlsPlace& place, const std::string& why) override;
  void tls_behind(std::chrono::milliseconds missed) override;
  void tls_drained() override;
  void client_bytes(gateway::ClientId client, modbus::Bytes bytes, std::size_t unread) override;
  void client_sent(gateway::ClientId client) override { process(gateway::ClientSent{client}); }
  void client_half_closed(gateway::ClientId client) override {
    process(gateway::ClientHalfClosed{client});
  }
  void client_disconnected(gateway::ClientId client, modbus::Bytes bytes) override;
  void client_closed(gateway::ClientId client) override;
  void line_opened(gateway::BusId bus, bus::LineKind kind,
                   const std::vector<std::string>& warnings) override;
  void line_bytes(gateway::BusId bus, modbus::Bytes bytes) override {
    process(gateway::LineBytes{bus, bytes});
  }
  void line_unsent(gateway::BusId bus, std::size_t bytes) override {
    feed(gateway::LineUnsent{bus, bytes});
  }
  void line_lost(gateway::BusId bus, const std::string& why) override;
  void line_closed(gateway::BusId bus, const std::string& why) override;
  [[nodiscard]] std::string name_of(gateway::BusId bus) const override {
    return gateway_.settings().bus(bus).name;
  }

  /// The only way into the machine. A recording has exactly the inputs that pass here.
  void feed(const gateway::Input& input);
  void hand_in(const gateway::Input& input, gateway::Instant at);
  /// Feeds it, and carries out what follows.
  void process(const gateway::Input& input);
  /// What clients have sent while this did not run is old. True if it has not run for too long.
  bool notice_stall(gateway::Instant at);
  void connected(gateway::ClientId id, const gateway::ClientInfo& info);
  /// Carries out the actions of the machine until there are none left, then sets the timer. A
  /// nested call (an action that causes an input) leaves the work to the outer call.
  void carry_out_actions();
  void set_timer();
  void wait_for_end_of_silence(const gateway::Wake& wake);
  /// Reads what can be read from the lines, then hands in DeadlineReached.
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
  Clock clock_;
  gateway::Instant started_;
  gateway::Gateway gateway_;
  bool carrying_out_ = false;
  BootTimer timer_;
  std::optional<gateway::Instant> timer_set_to_;
  /// Bytes that could be read at one instant are handed in with that instant, before the machine
  /// decides anything.
  std::optional<gateway::Instant> reading_at_;
  BlockingCalls blocking_;
  TlsDoor tls_;
  bool is_tls_behind_ = false;
  ClientConnections clients_;
  LineSet lines_;
  ServerSet servers_;
  enum class Phase : std::uint8_t { serving, flushing, finished };
  Phase phase_ = Phase::serving;
  boost::asio::steady_timer flush_timer_;
  Heartbeat heartbeat_;
};

}  // namespace mbgate::io

// SPDX-License-Identifier: Apache-2.0
// The running gateway as a process: binds the listeners, drives the machine, reports to systemd and
// to the operator, reads the configuration again on SIGHUP, and shuts down on SIGTERM or SIGINT.
//
// To change
// - listeners whose address does not exist yet: listeners.
// - listening sockets that outlive the process: stored_sockets; whether one fits a listener:
//   is_bound_for() in io/clients/listening_socket.
// - reports to systemd (ready, status, watchdog, sockets to keep): systemd (how), service (when).
// - signals that come while the process starts: mbgated.
// - the settings of mbgated --serial: command_line turns its options into the text of a
//   configuration.
// - advice for missing permissions: io/advice, printed by io/clients/listening_socket,
//   io/lines/tcp_line, control/control_doors, recording; for ports by io/lines/tty; the end of the
//   start at a denied listener: listeners; the permissions that a configuration needs, found
//   without trying: config/check_summary.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "app/control/control.hpp"
#include "app/http_listeners.hpp"
#include "app/listeners.hpp"
#include "app/log.hpp"
#include "app/stored_sockets.hpp"
#include "app/systemd.hpp"
#include "app/tls/certificates.hpp"
#include "config/load.hpp"
#include "io/blocking_calls.hpp"
#include "io/clients/listening_socket.hpp"
#include "io/gateway_driver.hpp"
#include "io/tls/load_tls.hpp"

namespace mbgate::app {

/// A configuration, and its files if a recording needs them.
struct Configuration {
  config::Loaded loaded;
  std::vector<report::ConfigFile> files;
  std::string digest{};    ///< config_digest()
  std::string digested{};  ///< digest_command()
  io::LoadedTls tls{};     ///< if there are settings
  std::string failure;     ///< why it could not be read; else empty
};

/// What the process is and runs with, for those who ask.
struct About {
  std::string version;
  std::string config;  ///< path of the configuration file
};

class Service final : public io::DriverObserver, public ControlTarget {
 public:
  /// Reads the configuration again, on a thread that may wait.
  using Read = std::function<Configuration()>;

  /// `read` also gives what it starts with.
  Service(Configuration first, About about, Read read, Log& log, io::Recorder* recorder);
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;
  ~Service() override;

  /// Serves until a signal ends it. Returns the exit status: 0; 78 if the settings need what this
  /// process may not do; or 1 if there are too few descriptors or a listener could not be bound
  /// (other than because its address does not exist yet). An exception means a fault of the
  /// program.
  int run();

 private:
  void on_event(const gateway::Event& event) override;
  void on_line_warning(gateway::BusId bus, const std::string& warning) override;
  void on_line_failure(gateway::BusId bus, const std::string& why) override;
  void on_accept_failure(gateway::ListenerId listener, const std::string& why) override;
  void on_tls_refusal(const io::TlsPlace& place, const std::string& why) override;
  void on_stall(std::chrono::milliseconds lasted) override;
  void on_status_changed() override;
  void on_finished() override;
  [[nodiscard]] gateway::StatusReport report_status(bool with_clients) const override;
  [[nodiscard]] ProcessStatus process_status() const override;
  void reload(const Asker& asker, ReloadEnded ended) override;
  void clear_counters(const Asker& asker) override;
  void command_denied(const Asker& asker, const std::string& what) override;
  [[nodiscard]] bool meets_deadlines() const override { return driver_.meets_deadlines(); }
  void set_traced(bool traced) override { driver_.set_traced(traced); }
  gateway::TraceBook::Taken take_trace() override { return driver_.take_trace(); }
  void control_failed(const std::string& why) override;
  void http_refused(const std::string& address) override;

  /// All listeners listen, or wait for their address. Else the exit status of the process.
  int begin_listening();
  boost::asio::awaitable<void> wait_for_signal();
  void stop();
  void begin_reload();
  /// Limited for each `kind` of those who ask.
  void say_who_reloads(const std::string& kind, const std::string& who);
  void finish_reload(const Configuration& read);
  /// False if it has errors, or needs what this process may not do. Says what it has to say.
  bool is_sound(const Configuration& read);
  /// False if they need what this process may not do, or leave a socket from systemd to everyone.
  /// Says what it has to say.
  bool may_listen(const gateway::Settings& settings);
  void forget_failures(const gateway::Settings& before, const gateway::Settings& next);
  /// Puts these settings into force. False if they cannot be: the journal says why.
  bool change(const Configuration& read);
  /// For the journal, and for those who asked for the reload.
  void say_of_reload(Level level, const std::string& text, MessageId id);
  void end_reload(bool done);
  void start_control();
  /// Are none missing? Says which are.
  bool has_certificates(const io::LoadedTls& tls);
  /// For the listeners of `next`.
  void use_certificates(const io::TlsContexts& contexts, const gateway::Settings& next);
  void send_status();
  [[nodiscard]] std::string status() const;
  [[nodiscard]] std::string bus_text(gateway::BusId bus, const std::string& text) const;

  Log& log_;
  About about_;
  Read read_;
  std::chrono::system_clock::time_point read_at_ = std::chrono::system_clock::now();
  // One thread runs it and uses its sockets, lines and timers; others only post to it.
  boost::asio::io_context context_{BOOST_ASIO_CONCURRENCY_HINT_UNSAFE_IO};
  boost::asio::signal_set signals_;
  io::BlockingCalls blocking_;
  io::SystemdSockets from_systemd_;
  bool reloading_ = false;   ///< from the reading on
  bool read_again_ = false;  ///< a reload was requested meanwhile
  bool is_refused_ = false;  ///< the last reload
  std::string digest_;       ///< of the configuration in force
  std::vector<std::string> reload_messages_;
  std::vector<ReloadEnded> reload_asked_;    ///< to be told of the next reading
  std::vector<ReloadEnded> reload_waiting_;  ///< of the one that runs
  boost::asio::steady_timer status_timer_;
  bool status_pending_ = false;
  bool ready_ = false;
  std::chrono::steady_clock::time_point last_status_time_;
  std::string last_status_;
  /// Failures already written to the journal: a lost line is tried again every few seconds and
  /// fails for the same reason.
  std::vector<std::set<std::string>> failures_;
  std::set<std::string> warnings_;
  Certificates certificates_;
  io::LoadedTls first_tls_;  ///< until it listens
  io::GatewayDriver driver_;
  StoredSockets stored_;
  Listeners listeners_;
  Control control_;
  HttpListeners http_;
  Watchdog watchdog_;
};

}  // namespace mbgate::app

// SPDX-License-Identifier: Apache-2.0
#include "app/service.hpp"

#include <sysexits.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <iterator>
#include <utility>
#include <variant>

#include "app/configuration/digest.hpp"
#include "app/journal/event_topic.hpp"
#include "app/mbgated.hpp"
#include "app/text.hpp"
#include "io/clients/resources.hpp"
#include "io/supervise.hpp"

namespace mbgate::app {
namespace {

using boost::asio::ip::tcp;
using gateway::BusId;
using gateway::ListenerId;

/// systemd shows the status text; nobody reads it faster than this.
constexpr std::chrono::seconds kStatusInterval{1};

}  // namespace

Service::Service(Configuration first, About about, Read read, Log& log, io::Recorder* recorder)
    : log_(log),
      about_(std::move(about)),
      read_(std::move(read)),
      signals_(context_, SIGTERM, SIGINT, SIGHUP),
      blocking_(context_),
      digest_(std::move(first.digest)),
      status_timer_(context_),
      failures_(first.loaded.settings->buses.size()),
      certificates_(context_, log),
      first_tls_(std::move(first.tls)),
      driver_(context_, *std::move(first.loaded.settings), *this, recorder),
      listeners_(context_, log,
                 [this](ListenerId listener, tcp::acceptor acceptor) {
                   driver_.add_server(listener, std::move(acceptor));
                   on_status_changed();
                 }),
      control_(context_, *this),
      http_(context_, log, control_),
      watchdog_(
          context_, [this] { return driver_.meets_deadlines(); }, notify_alive) {
  release_held_signals();
  listeners_.use(stored_);
  http_.use(stored_);
}

Service::~Service() { log_.observe({}); }

int Service::begin_listening() {
  const gateway::Settings& settings = driver_.settings();
  auto inherited = take_inherited_sockets();
  auto all = settings.listeners;
  std::ranges::copy(http_listeners({}, settings.http), std::back_inserter(all));
  stored_.take(inherited, all);
  for (const auto& socket : inherited) {
    from_systemd_.add(socket.name, socket.fd.get());
  }
  if (!may_listen(settings)) {
    return EX_CONFIG;
  }
  if (!has_certificates(first_tls_)) {
    return first_tls_.is_wrong ? EX_CONFIG : EXIT_FAILURE;
  }
  use_certificates(std::exchange(first_tls_, {}).contexts, settings);
  http_.take(settings, inherited);
  const auto descriptors =
      io::room_for_clients(settings, io::raise_descriptor_limit(), http_.inherited());
  if (descriptors.shortage) {
    log_.write(descriptors.clients == 0 ? Level::error : Level::warning, *descriptors.shortage,
               {.id = message_id::kTooFewDescriptors});
  }
  const bool serves =
      descriptors.clients > 0 && listeners_.begin(settings.listeners, std::move(inherited));
  if (serves) {
    return EXIT_SUCCESS;
  }
  return listeners_.is_denied() ? EX_CONFIG : EXIT_FAILURE;
}

int Service::run() {
  if (const int status = begin_listening(); status != EXIT_SUCCESS) {
    return status;
  }
  driver_.start();
  control_.set_end(io::end_of_client_descriptors(driver_.settings()));
  start_control();
  log_.write(Level::info, in_force_text(digest_), {.id = message_id::kConfigurationDigest});
  log_.observe([this](Level level, const std::string& text) { control_.tell(level, text); });
  http_.begin(driver_.settings().http);
  stored_.end_unclaimed();
  // Only now: whoever waits for its lines connects to a process that has started.
  listeners_.start();
  http_.start();
  io::supervise(context_, wait_for_signal(), "signals");
  ready_ = true;
  last_status_ = status();
  last_status_time_ = std::chrono::steady_clock::now();
  notify_ready(last_status_);
  if (const auto limit = watchdog_limit()) {
    watchdog_.start(*limit);
  }
  context_.run();
  return EXIT_SUCCESS;
}

boost::asio::awaitable<void> Service::wait_for_signal() {
  while (true) {
    const auto [error, signal] = co_await signals_.async_wait(io::kAsTuple);
    if (error || signal != SIGHUP) {
      break;
    }
    say_who_reloads("signal", "SIGHUP");
    begin_reload();
  }
  stop();
}

void Service::stop() {
  log_.write(Level::info, "stopping", {.id = message_id::kStopping});
  status_timer_.cancel();
  certificates_.stop();
  ready_ = false;
  notify_stopping();
  listeners_.stop();
  http_.stop();
  stored_.let_go();
  driver_.shutdown();
}

void Service::on_event(const gateway::Event& event) {
  if (const auto* const opened = std::get_if<gateway::BusOpened>(&event)) {
    failures_[static_cast<std::size_t>(opened->bus)].clear();
  }
  write_event(log_, event, driver_.settings());
}

void Service::on_line_warning(BusId bus, const std::string& warning) {
  const std::string text = bus_text(bus, warning);
  if (warnings_.insert(text).second) {
    log_.write(Level::warning, text,
               {.id = message_id::kLineWarning, .bus = driver_.settings().bus(bus).name});
  }
}

void Service::on_line_failure(BusId bus, const std::string& why) {
  if (failures_[static_cast<std::size_t>(bus)].insert(why).second) {
    log_.write_limited(Level::warning, fmt::format("line failure {}", fmt::underlying(bus)),
                       bus_text(bus, why),
                       {.id = message_id::kLineFailure, .bus = driver_.settings().bus(bus).name});
  }
}

void Service::on_accept_failure(ListenerId listener, const std::string& why) {
  const std::string& name = driver_.settings().listener(listener).name;
  log_.write_limited(Level::error, fmt::format("accept failure {}", fmt::underlying(listener)),
                     fmt::format("listener {}: cannot accept clients: {}", name, why),
                     {.id = message_id::kAcceptFailed, .listener = name});
}

void Service::on_stall(std::chrono::milliseconds lasted) {
  log_.write_limited(
      Level::warning, "stall",
      fmt::format("the gateway did not run for {} ms: it was stopped, or got no processor time. "
                  "Requests that came meanwhile count as sent at the beginning of that time",
                  lasted.count()),
      {.id = message_id::kStalled});
}

void Service::on_status_changed() {
  if (!ready_ || status_pending_) {
    return;
  }
  const auto due = last_status_time_ + kStatusInterval;
  status_pending_ = true;
  status_timer_.expires_at(due);
  status_timer_.async_wait([this](const boost::system::error_code& error) {
    status_pending_ = false;
    if (!error && ready_) {
      send_status();
    }
  });
}

void Service::send_status() {
  last_status_time_ = std::chrono::steady_clock::now();
  std::string text = status();
  if (text != last_status_) {
    last_status_ = std::move(text);
    notify_status(last_status_);
  }
}

std::string Service::status() const {
  const std::string text = status_text(driver_.settings(), driver_.status(), listeners_.waiting());
  return is_refused_ ? "the last reload was refused, see the journal; " + text : text;
}

void Service::on_finished() { context_.stop(); }

gateway::StatusReport Service::report_status(bool with_clients) const {
  return driver_.report_status(with_clients);
}

ProcessStatus Service::process_status() const {
  return {about_.version,         about_.config,           read_at_, is_refused_, digest_,
          certificates_.status(), certificates_.failures()};
}

void Service::clear_counters(const Asker& asker) {
  driver_.clear_counters();
  log_.write_limited(Level::notice, "counters cleared " + asker.client,
                     "counters cleared over the control socket: " + asker.text,
                     {.id = message_id::kCountersCleared});
}

void Service::control_failed(const std::string& why) {
  log_.write_limited(Level::error, "control failure",
                     "a connection to the control socket has failed: " + why,
                     {.id = message_id::kControlFailed});
}

void Service::http_refused(const std::string& address) {
  log_.write_limited(Level::warning, "http refused",
                     fmt::format("http: client {} refused: not in [http] allow", address),
                     {.id = message_id::kHttpRefused, .client = address});
}

// Drives are served without it too.
void Service::start_control() {
  std::string path = driver_.settings().control_socket;
  if (path.empty()) {
    return;
  }
  const char* const folder = std::getenv("RUNTIME_DIRECTORY");  // of the unit (systemd.exec)
  if (path == gateway::Settings{}.control_socket && folder != nullptr) {
    const std::string_view all = folder;
    path = std::filesystem::path(all.substr(0, all.find(':'))) / "control";
  }
  const std::string failure = control_.listen_at(path);
  if (!failure.empty()) {
    log_.write(Level::warning, failure, {.id = message_id::kControlFailed});
  }
}

std::string Service::bus_text(BusId bus, const std::string& text) const {
  return fmt::format("bus {}: {}", driver_.settings().bus(bus).name, text);
}

}  // namespace mbgate::app

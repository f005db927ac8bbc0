// SPDX-License-Identifier: Apache-2.0
#include "app/service.hpp"

#include <algorithm>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <csignal>
#include <cstdlib>
#include <type_traits>
#include <utility>
#include <variant>

#include "app/changes.hpp"
#include "app/systemd.hpp"
#include "app/text.hpp"
#include "gateway/settings/numbering.hpp"
#include "io/clients/descriptors.hpp"
#include "io/supervise.hpp"

namespace mbgate::app {
namespace {

using boost::asio::ip::tcp;
using gateway::BusId;
using gateway::ListenerId;

/// systemd shows the status text; nobody reads it faster than this.
constexpr std::chrono::seconds kStatusInterval{1};

Level level_of(const gateway::Event& event) {
  return std::visit(
      [](const auto& value) {
        using Kind = std::decay_t<decltype(value)>;
        constexpr bool kOrdinary = std::is_same_v<Kind, gateway::BusOpened> ||
                                   std::is_same_v<Kind, gateway::ClientDisplaced> ||
                                   std::is_same_v<Kind, gateway::ClientFrameTimedOut>;
        return kOrdinary ? Level::notice : Level::warning;
      },
      event);
}

/// Events of one kind at one place share a rate limit: a bus that flaps must not hide another.
std::string kind_of(const gateway::Event& event) {
  return std::visit(
      [&](const auto& value) {
        std::string kind = std::to_string(event.index());
        if constexpr (requires { value.bus, value.address; }) {
          return kind + " bus " + std::to_string(static_cast<std::uint32_t>(value.bus)) +
                 " address " + std::to_string(value.address);
        } else if constexpr (requires { value.bus; }) {
          return kind + " bus " + std::to_string(static_cast<std::uint32_t>(value.bus));
        } else {
          return kind + " listener " + std::to_string(static_cast<std::uint32_t>(value.listener));
        }
      },
      event);
}

}  // namespace

Service::Service(gateway::Settings settings, Read read, Log& log, io::Recorder* recorder)
    : log_(log),
      read_(std::move(read)),
      signals_(context_, SIGTERM, SIGINT, SIGHUP),
      blocking_(context_),
      status_timer_(context_),
      failures_(settings.buses.size()),
      driver_(context_, std::move(settings), *this, recorder),
      listeners_(context_, log, [this](ListenerId listener, tcp::acceptor acceptor) {
        driver_.add_server(listener, std::move(acceptor));
        on_status_changed();
      }) {
  // What other daemons take for "tell" or "reopen your log" must not end a gateway of drives.
  for (const int ignored : {SIGPIPE, SIGUSR1, SIGUSR2}) {
    std::signal(ignored, SIG_IGN);
  }
}

int Service::run() {
  const auto descriptors = io::room_for_clients(driver_.settings(), io::raise_descriptor_limit());
  if (descriptors.shortage) {
    log_.write(descriptors.clients == 0 ? Level::error : Level::warning, *descriptors.shortage);
  }
  if (descriptors.clients == 0 ||
      !listeners_.begin(driver_.settings().listeners, take_inherited_sockets())) {
    return EXIT_FAILURE;
  }
  driver_.start();
  // Only now: whoever waits for its lines connects to a process that has started.
  listeners_.start();
  io::supervise(context_, wait_for_signal(), "signals");
  ready_ = true;
  last_status_ = status();
  last_status_time_ = std::chrono::steady_clock::now();
  notify_ready(last_status_);
  context_.run();
  return EXIT_SUCCESS;
}

boost::asio::awaitable<void> Service::wait_for_signal() {
  while (true) {
    const auto [error, signal] =
        co_await signals_.async_wait(boost::asio::as_tuple(boost::asio::use_awaitable));
    if (error || signal != SIGHUP) {
      break;
    }
    begin_reload();
  }
  stop();
}

void Service::stop() {
  log_.write(Level::info, "stopping");
  status_timer_.cancel();
  ready_ = false;
  notify_stopping();
  listeners_.stop();
  driver_.shutdown();
}

void Service::begin_reload() {
  if (reading_) {
    read_again_ = true;
    return;
  }
  notify_reloading();
  reading_ = blocking_.run(read_, [this](const Configuration& read) { finish_reload(read); });
  if (!reading_) {
    log_.write(Level::error, "the configuration stays as it is: no thread to read it on");
    is_refused_ = true;
    last_status_ = status();
    notify_ready(last_status_);
  }
}

void Service::finish_reload(const Configuration& read) {
  reading_ = false;
  if (!ready_) {
    return;  // the process ends
  }
  is_refused_ = !change(read);
  if (is_refused_) {
    log_.write(Level::error, "the configuration stays as it is");
  }
  last_status_ = status();
  notify_ready(last_status_);
  if (std::exchange(read_again_, false)) {
    begin_reload();
  }
}

bool Service::change(const Configuration& read) {
  if (!read.failure.empty()) {
    log_.write(Level::error, read.failure);
    return false;
  }
  for (const auto& diagnostic : read.loaded.diagnostics) {
    log_.write(diagnostic.severity == config::Severity::error ? Level::error : Level::warning,
               config::headline(diagnostic));
  }
  if (!read.loaded.settings) {
    return false;
  }
  const gateway::Settings before = driver_.settings();
  const gateway::Settings next = gateway::numbered_after(before, *read.loaded.settings);
  if (!listeners_.reload(before.listeners, next.listeners,
                         [this](ListenerId listener) { driver_.remove_servers(listener); })) {
    return false;
  }
  forget_failures(before, next);
  driver_.reload(*read.loaded.settings, read.text);
  const auto changes = changes_between(before, next);
  for (const auto& change : changes) {
    log_.write(Level::notice, "reload: " + change);
  }
  log_.write(Level::info, changes.empty() ? "reload: nothing has changed" : "reload: done");
  if (before.lock_memory != next.lock_memory) {
    log_.write(Level::warning, "reload: lock_memory takes effect at the next start");
  }
  return true;
}

// What was said of another line may be wrong of this one, or is to be said again.
void Service::forget_failures(const gateway::Settings& before, const gateway::Settings& next) {
  failures_.resize(next.buses.size());
  for (std::size_t bus = 0; bus < before.buses.size(); ++bus) {
    if (!gateway::keeps_line(before, next, static_cast<BusId>(bus))) {
      failures_[bus].clear();
      warnings_.clear();
    }
  }
}

void Service::on_event(const gateway::Event& event) {
  if (const auto* const opened = std::get_if<gateway::BusOpened>(&event)) {
    failures_[static_cast<std::size_t>(opened->bus)].clear();
  }
  log_.write_limited(level_of(event), kind_of(event), to_text(event, driver_.settings()));
}

void Service::on_line_warning(BusId bus, const std::string& warning) {
  const std::string text = bus_text(bus, warning);
  if (warnings_.insert(text).second) {
    log_.write(Level::warning, text);
  }
}

void Service::on_line_failure(BusId bus, const std::string& why) {
  if (failures_[static_cast<std::size_t>(bus)].insert(why).second) {
    log_.write_limited(Level::warning,
                       "line failure " + std::to_string(static_cast<std::uint32_t>(bus)),
                       bus_text(bus, why));
  }
}

void Service::on_accept_failure(ListenerId listener, const std::string& why) {
  log_.write_limited(
      Level::error, "accept failure " + std::to_string(static_cast<std::uint32_t>(listener)),
      "listener " + driver_.settings().listener(listener).name + ": cannot accept clients: " + why);
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

std::string Service::bus_text(BusId bus, const std::string& text) const {
  return "bus " + driver_.settings().bus(bus).name + ": " + text;
}

}  // namespace mbgate::app

// SPDX-License-Identifier: Apache-2.0
#include "app/service.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <csignal>
#include <cstdlib>
#include <type_traits>
#include <utility>
#include <variant>

#include "app/text.hpp"
#include "io/listening_socket.hpp"
#include "io/supervise.hpp"

namespace mbgate::app {
namespace {

using boost::asio::ip::tcp;
using gateway::BusId;
using gateway::ListenerId;

/// systemd shows the status text; nobody reads it faster than this.
constexpr std::chrono::seconds kStatusInterval{1};

/// The soft limit is 1024 for the sake of select(2), which nobody here uses.
void raise_descriptor_limit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) == 0) {
    limit.rlim_cur = limit.rlim_max;
    ::setrlimit(RLIMIT_NOFILE, &limit);
  }
}

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

Service::Service(gateway::Settings settings, Log& log, io::Recorder* recorder)
    : log_(log),
      signals_(context_, SIGTERM, SIGINT),
      status_timer_(context_),
      failures_(settings.buses.size()),
      driver_(context_, std::move(settings), *this, recorder) {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGHUP, SIG_IGN);
}

int Service::run() {
  raise_descriptor_limit();
  if (!listen_on_all()) {
    return EXIT_FAILURE;
  }
  driver_.start();
  // Only now: whoever waits for these lines connects to a process that has started.
  for (const auto& line : listening_) {
    log_.print(line);
  }
  io::supervise(context_, wait_for_signal(), "signals");
  ready_ = true;
  last_status_ = status_text(driver_.settings(), driver_.status());
  last_status_time_ = std::chrono::steady_clock::now();
  notify_ready(last_status_);
  context_.run();
  return EXIT_SUCCESS;
}

bool Service::listen_on_all() {
  std::vector<InheritedSocket> inherited = take_inherited_sockets();
  bool all = true;
  for (std::size_t i = 0; i < driver_.settings().listeners.size(); ++i) {
    all = listen(static_cast<ListenerId>(i), inherited) && all;
  }
  for (const auto& socket : inherited) {
    if (socket.fd.is_open()) {
      log_.write(Level::warning,
                 "the socket \"" + socket.name + "\" from systemd has the name of no listener");
    }
  }
  return all;
}

bool Service::listen(ListenerId id, std::vector<InheritedSocket>& inherited) {
  const auto& listener = driver_.settings().listener(id);
  bool adopted = false;
  bool all = true;
  for (auto& socket : inherited) {
    if (socket.fd.is_open() && socket.name == listener.name) {
      adopted = true;
      all = add_server(id, io::adopt_listener(context_, listener, std::move(socket.fd))) && all;
    }
  }
  return adopted ? all : add_server(id, io::bind_listener(context_, listener));
}

bool Service::add_server(ListenerId id, Result<tcp::acceptor, std::string> acceptor) {
  if (!acceptor) {
    log_.write(Level::error, acceptor.error());
    return false;
  }
  listening_.push_back("listening " + driver_.settings().listener(id).name + " " +
                       io::to_text(acceptor->local_endpoint()));
  driver_.add_server(id, *std::move(acceptor));
  return true;
}

boost::asio::awaitable<void> Service::wait_for_signal() {
  co_await signals_.async_wait(boost::asio::as_tuple(boost::asio::use_awaitable));
  log_.write(Level::info, "stopping");
  status_timer_.cancel();
  ready_ = false;
  notify_stopping();
  driver_.shutdown();
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
  std::string status = status_text(driver_.settings(), driver_.status());
  if (status != last_status_) {
    last_status_ = std::move(status);
    notify_status(last_status_);
  }
}

void Service::on_finished() { context_.stop(); }

std::string Service::bus_text(BusId bus, const std::string& text) const {
  return "bus " + driver_.settings().bus(bus).name + ": " + text;
}

}  // namespace mbgate::app

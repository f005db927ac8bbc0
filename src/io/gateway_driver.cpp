// SPDX-License-Identifier: Apache-2.0
#include "io/gateway_driver.hpp"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <chrono>
#include <utility>
#include <variant>

#include "io/clients/descriptors.hpp"

namespace mbgate::io {
namespace {

using gateway::BusId;
using gateway::ClientId;
using gateway::ListenerId;

/// How long a connection that the machine has closed may take to send what was queued.
constexpr std::chrono::seconds kCloseLimit{1};
/// The same at the end of the process: with the machine's own 1.5 s it makes less than 2 s.
constexpr std::chrono::milliseconds kFlushLimit{250};

}  // namespace

GatewayDriver::GatewayDriver(boost::asio::io_context& context, gateway::Settings settings,
                             DriverObserver& observer, Recorder* recorder)
    : context_(context),
      observer_(observer),
      recorder_(recorder),
      started_(now()),
      gateway_(std::move(settings), started_),
      timer_(context),
      blocking_(context),
      clients_(context, *this),
      lines_({context, blocking_, *this}),
      servers_(context, *this),
      flush_timer_(context) {
  if (recorder_ != nullptr) {
    recorder_->begin(started_);
  }
}

void GatewayDriver::add_server(ListenerId listener, boost::asio::ip::tcp::acceptor acceptor) {
  servers_.add(listener, std::move(acceptor), end_of_client_descriptors(settings()));
}

void GatewayDriver::remove_servers(ListenerId listener) { servers_.remove(listener); }

void GatewayDriver::start() {
  carry_out_actions();
  servers_.start();
  phase_ = Phase::serving;
}

void GatewayDriver::reload(const gateway::Settings& settings, std::string_view config) {
  feed(gateway::SettingsChanged{&settings, config});
  servers_.set_end(end_of_client_descriptors(gateway_.settings()));
  carry_out_actions();
  observer_.on_status_changed();
}

void GatewayDriver::clear_counters() {
  feed(gateway::ClearCountersAsked{});
  carry_out_actions();
}

gateway::StatusReport GatewayDriver::report_status() const {
  const gateway::Instant at = now();
  return gateway_.report_status(at - started_, at);
}

void GatewayDriver::shutdown() {
  servers_.stop();
  feed(gateway::ShutdownAsked{});
  carry_out_actions();
}

void GatewayDriver::client_accepted(ListenerId listener, AcceptedClient client) {
  const ClientId id = clients_.add(std::move(client.socket));
  feed(gateway::ClientConnected{id, {listener, client.address(), client.bytes_waiting}});
  carry_out_actions();
  if (auto* const added = clients_.find(id)) {
    added->start();
  }
  observer_.on_status_changed();
}

void GatewayDriver::accept_failed(ListenerId listener, const boost::system::error_code& error) {
  observer_.on_accept_failure(listener, error.message());
}

void GatewayDriver::client_bytes(ClientId client, modbus::Bytes bytes, std::size_t unread) {
  feed(gateway::ClientBytes{client, bytes, unread});
  carry_out_actions();
}

void GatewayDriver::client_sent(ClientId client) {
  feed(gateway::ClientSent{client});
  carry_out_actions();
}

void GatewayDriver::client_half_closed(ClientId client) {
  feed(gateway::ClientHalfClosed{client});
  carry_out_actions();
}

void GatewayDriver::client_disconnected(ClientId client) {
  clients_.note_disconnected(client);
  feed(gateway::ClientDisconnected{client});
  carry_out_actions();
  observer_.on_status_changed();
}

void GatewayDriver::client_closed(ClientId /*client*/) {
  clients_.note_closed();
  if (phase_ == Phase::flushing && !clients_.are_closing()) {
    finish();
  }
}

void GatewayDriver::line_opened(BusId bus, bus::LineKind kind,
                                const std::vector<std::string>& warnings) {
  for (const auto& warning : warnings) {
    observer_.on_line_warning(bus, warning);
  }
  feed(gateway::LineOpened{bus, kind});
  carry_out_actions();
  observer_.on_status_changed();
}

void GatewayDriver::line_bytes(BusId bus, modbus::Bytes bytes) {
  feed(gateway::LineBytes{bus, bytes});
  carry_out_actions();
}

void GatewayDriver::line_lost(BusId bus, const std::string& why) {
  observer_.on_line_failure(bus, why);
  feed(gateway::LineLost{bus});
  carry_out_actions();
  observer_.on_status_changed();
}

void GatewayDriver::line_closed(BusId bus, const std::string& why) {
  feed(gateway::LineLost{bus, bus::Loss::closed});
  if (!gateway_.is_open(bus)) {
    observer_.on_line_failure(bus, why);
  }
  carry_out_actions();
  observer_.on_status_changed();
}

void GatewayDriver::feed(const gateway::Input& input) {
  const gateway::Instant at = reading_at_.value_or(now());
  if (recorder_ != nullptr) {
    recorder_->note(input, at);
  }
  gateway_.handle(input, at);
}

void GatewayDriver::carry_out_actions() {
  if (carrying_out_ || reading_at_) {
    return;
  }
  carrying_out_ = true;
  while (const auto action = gateway_.poll_action()) {
    if (recorder_ != nullptr) {
      recorder_->note(*action, gateway_.settings());
    }
    std::visit([this](const auto& wanted) { carry_out(wanted); }, *action);
  }
  carrying_out_ = false;
  if (recorder_ != nullptr) {
    recorder_->hand_over();
  }
  set_timer();
}

void GatewayDriver::set_timer() {
  const auto wake = gateway_.next_wake();
  // A timer that goes off too early costs a spurious call; one that is set anew each time costs a
  // system call.
  if (!wake) {
    return;
  }
  const gateway::Instant ring =
      wake->silence_of ? wake->at - gateway_.settings().wake_early : wake->at;
  if (timer_set_to_ && *timer_set_to_ <= ring) {
    return;
  }
  timer_set_to_ = ring;
  timer_.expires_at(to_steady(ring));
  timer_.async_wait([this](const boost::system::error_code& error) {
    if (!error) {
      timer_set_to_.reset();
      handle_wake();
    }
  });
}

void GatewayDriver::handle_wake() {
  if (const auto wake = gateway_.next_wake()) {
    wait_for_end_of_silence(*wake);
  }
  reading_at_ = now();
  lines_.read_now();
  feed(gateway::DeadlineReached{});
  reading_at_.reset();
  carry_out_actions();
}

// Not for long: the timer rang early for it. Nothing is lost when a byte ends it: what it means,
// the machine says.
void GatewayDriver::wait_for_end_of_silence(const gateway::Wake& wake) {
  if (!wake.silence_of || wake.at - now() > gateway_.settings().wake_early) {
    return;
  }
  Line& watched = lines_[*wake.silence_of];
  while (now() < wake.at && !watched.has_bytes()) {
  }
}

void GatewayDriver::carry_out(const gateway::Send& action) {
  auto* const client = clients_.find(action.client);
  if (client == nullptr) {
    return;
  }
  switch (client->send(action.adu)) {
    case TcpConnection::SendOutcome::sent: feed(gateway::ClientSent{action.client}); return;
    case TcpConnection::SendOutcome::queued: return;
    case TcpConnection::SendOutcome::failed: drop(action.client); return;
  }
}

void GatewayDriver::carry_out(const gateway::Pause& action) {
  auto* const client = clients_.find(action.client);
  if (client != nullptr && !client->pause()) {
    drop(action.client);
  }
}

void GatewayDriver::carry_out(const gateway::Resume& action) {
  if (auto* const client = clients_.find(action.client)) {
    client->resume();
  }
}

void GatewayDriver::carry_out(const gateway::Close& action) {
  clients_.close(action.client, kCloseLimit);
  observer_.on_status_changed();
}

void GatewayDriver::carry_out(const gateway::Open& action) {
  lines_.with_settings(action.bus, settings().bus(action.bus).line).open();
}

void GatewayDriver::carry_out(const gateway::Look& action) {
  lines_[action.bus].read_now();
  feed(gateway::LineLooked{action.bus});
}

void GatewayDriver::carry_out(const gateway::Transmit& action) {
  if (const auto why = lines_[action.bus].transmit(action.frame)) {
    observer_.on_line_failure(action.bus, *why);
    feed(gateway::LineLost{action.bus});
    observer_.on_status_changed();
  }
}

void GatewayDriver::carry_out(const gateway::Shut& action) { lines_[action.bus].close(); }

void GatewayDriver::carry_out(const gateway::Report& action) { observer_.on_event(action.event); }

void GatewayDriver::carry_out(const gateway::Finished& /*action*/) {
  clients_.close_all(kFlushLimit);
  phase_ = Phase::flushing;
  flush_timer_.expires_after(clients_.are_closing() ? kFlushLimit : std::chrono::milliseconds(0));
  flush_timer_.async_wait([this](const boost::system::error_code& error) {
    if (!error) {
      finish();
    }
  });
}

void GatewayDriver::drop(ClientId client) {
  if (clients_.abort(client)) {
    feed(gateway::ClientDisconnected{client});
    observer_.on_status_changed();
  }
}

void GatewayDriver::finish() {
  if (std::exchange(phase_, Phase::finished) != Phase::finished) {
    observer_.on_finished();
  }
}

}  // namespace mbgate::io

// SPDX-License-Identifier: Apache-2.0
#include "io/gateway_driver.hpp"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <chrono>
#include <utility>
#include <variant>

#include "gateway/access/rule_verdict.hpp"
#include "io/clients/resources.hpp"

namespace mbgate::io {
namespace {

using gateway::BusId;
using gateway::ClientId;
using gateway::ListenerId;

/// More than lies in any socket: what a client with TLS has sent before the thread of TLS was
/// stopped may not have come to its socket here.
constexpr std::size_t kStillBehind = 1UL << 24U;

}  // namespace

GatewayDriver::GatewayDriver(boost::asio::io_context& context, gateway::Settings settings,
                             DriverObserver& observer, Recorder* recorder, Clock clock)
    : context_(context),
      observer_(observer),
      recorder_(recorder),
      clock_(clock),
      started_(clock()),
      gateway_(std::move(settings), started_),
      timer_(context,
             [this] {
               timer_set_to_.reset();
               handle_wake();
             }),
      blocking_(context),
      tls_(context, *this),
      clients_(context, *this),
      lines_({context, blocking_, *this}),
      servers_(context, *this),
      flush_timer_(context),
      heartbeat_(context, [this] {
        notice_stall(clock_());
        carry_out_actions();
      }) {
  if (recorder_ != nullptr) {
    recorder_->begin(started_);
  }
}

void GatewayDriver::add_server(ListenerId listener, boost::asio::ip::tcp::acceptor acceptor) {
  servers_.add(listener, std::move(acceptor), end_of_client_descriptors(settings()));
}

void GatewayDriver::start() {
  carry_out_actions();
  servers_.start();
}

void GatewayDriver::reload(const gateway::Settings& settings, std::string_view config) {
  notice_stall(clock_());
  carry_out_actions();
  hand_in(gateway::SettingsChanged{&settings, config}, clock_());
  servers_.set_end(end_of_client_descriptors(gateway_.settings()));
  carry_out_actions();
  observer_.on_status_changed();
}

gateway::StatusReport GatewayDriver::report_status(bool with_clients) const {
  const gateway::Instant at = clock_();
  return gateway_.report_status(at - started_, at, with_clients);
}

void GatewayDriver::shutdown() {
  servers_.stop();
  process(gateway::ShutdownAsked{});
}

void GatewayDriver::client_accepted(ListenerId listener, AcceptedClient client) {
  notice_stall(clock_());
  const gateway::ListenerSettings& where = settings().listener(listener);
  gateway::ClientInfo info{listener, address_of(client.peer)};
  if (where.tls && !where.is_gone) {
    info.role.kind = routing::ClientRole::Kind::named;  // which one is not known yet
    const bool allowed = routing::lets_in(where.allow, info.address);
    if (allowed && gateway::may_connect(settings(), info)) {
      tls_.take(listener, settings(), std::move(client));
      return;
    }
    // Who may not connect is closed before a byte is read: by the machine, as others are.
  }
  if (unread_bytes(client.socket.native_handle()) > 0) {
    info.waits_since = client.connected;
  }
  connected(clients_.add(std::move(client.socket)), info);
}

void GatewayDriver::connected(ClientId id, const gateway::ClientInfo& info) {
  process(gateway::ClientConnected{id, info});
  if (auto* const added = clients_.find(id)) {
    added->start();
  }
  observer_.on_status_changed();
}

void GatewayDriver::accept_failed(ListenerId listener, const boost::system::error_code& error) {
  observer_.on_accept_failure(listener, error.message());
}

// It may have stood still since it looked into the socket, and more may have come.
void GatewayDriver::client_bytes(ClientId client, modbus::Bytes bytes, std::size_t unread) {
  const auto* const connection = is_tls_behind_ ? clients_.find(client) : nullptr;
  const bool is_relay_behind = connection != nullptr && connection->is_relayed();
  const gateway::Instant at = reading_at_.value_or(clock_());
  const bool more_is_old = notice_stall(at) || is_relay_behind;
  hand_in(gateway::ClientBytes{client, bytes, more_is_old ? unread + kStillBehind : unread}, at);
  carry_out_actions();
}

void GatewayDriver::client_disconnected(ClientId client, modbus::Bytes bytes) {
  clients_.note_disconnected(client);
  process(gateway::ClientDisconnected{client, bytes});
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
  process(gateway::LineOpened{bus, kind});
  observer_.on_status_changed();
}

void GatewayDriver::line_lost(BusId bus, const std::string& why) {
  observer_.on_line_failure(bus, why);
  process(gateway::LineLost{bus});
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
  const gateway::Instant at = reading_at_.value_or(clock_());
  notice_stall(at);
  hand_in(input, at);
}

void GatewayDriver::process(const gateway::Input& input) {
  feed(input);
  carry_out_actions();
}

void GatewayDriver::hand_in(const gateway::Input& input, gateway::Instant at) {
  if (recorder_ != nullptr) {
    recorder_->note(input, at);
  }
  gateway_.handle(input, at);
}

// Before anything of a client is read.
bool GatewayDriver::notice_stall(gateway::Instant at) {
  const auto missed = heartbeat_.missed(at);
  if (!missed) {
    return false;
  }
  hand_in(gateway::Stalled{*missed}, at);
  observer_.on_stall(*missed);
  boost::asio::post(context_, [this] { clients_.read_all(); });
  return true;
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
  heartbeat_.beat_while(!clients_.empty() && phase_ != Phase::finished, clock_());
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
  timer_.set(ring - clock_());
}

void GatewayDriver::handle_wake() {
  if (const auto wake = gateway_.next_wake()) {
    wait_for_end_of_silence(*wake);
  }
  reading_at_ = clock_();
  lines_.read_now();
  feed(gateway::DeadlineReached{});
  reading_at_.reset();
  carry_out_actions();
}

// Not for long: the timer rang early for it. Nothing is lost when a byte ends it: what it means,
// the machine says.
void GatewayDriver::wait_for_end_of_silence(const gateway::Wake& wake) {
  if (!wake.silence_of || wake.at - clock_() > gateway_.settings().wake_early) {
    return;
  }
  Line& watched = lines_[*wake.silence_of];
  while (clock_() < wake.at && !watched.has_bytes()) {
  }
}

void GatewayDriver::drop(ClientId client) {
  if (const auto unread = clients_.abort(client)) {
    feed(gateway::ClientDisconnected{client, *unread});
    observer_.on_status_changed();
  }
}

void GatewayDriver::finish() {
  if (std::exchange(phase_, Phase::finished) != Phase::finished) {
    heartbeat_.beat_while(false, clock_());
    observer_.on_finished();
  }
}

}  // namespace mbgate::io

// SPDX-License-Identifier: Apache-2.0
// Carries out the actions of the machine.
#include <sys/socket.h>

#include <algorithm>
#include <chrono>

#include "io/gateway_driver.hpp"

namespace mbgate::io {
namespace {

/// How long a connection that the machine has closed may take to send what was queued.
constexpr std::chrono::seconds kCloseLimit{1};
/// The same at the end of the process: with the machine's own 1.5 s it makes less than 2 s.
constexpr std::chrono::milliseconds kFlushLimit{250};

}  // namespace

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

void GatewayDriver::use_tls(const TlsContexts& contexts, const gateway::Settings& next) {
  ListenerContexts of_listeners;
  for (std::size_t i = 0; i < next.listeners.size(); ++i) {
    const gateway::ListenerSettings& listener = next.listeners[i];
    if (listener.is_gone || !listener.tls) {
      continue;
    }
    const auto context = contexts.find(next.tls[*listener.tls].name);
    if (context != contexts.end()) {
      of_listeners.emplace(static_cast<gateway::ListenerId>(i), context->second);
    }
  }
  tls_.use(std::move(of_listeners));
}

void GatewayDriver::tls_arrived(TlsArrival arrival) {
  notice_stall(clock_());
  ClientSocket socket(context_);
  boost::system::error_code error;
  socket.assign({AF_UNIX, 0}, arrival.socket.get(), error);
  if (error || phase_ == Phase::finished) {
    observer_.on_accept_failure(arrival.place.listener, error.message());
    return;
  }
  arrival.socket.release();
  gateway::ClientInfo info{arrival.place.listener, arrival.place.address, {}, arrival.role};
  if (unread_bytes(socket.native_handle()) > 0) {
    info.waits_since = arrival.since;
  }
  const gateway::ClientId id = clients_.add(std::move(socket));
  clients_.find(id)->set_relayed();
  connected(id, info);
}

void GatewayDriver::tls_refused(const TlsPlace& place, const std::string& why) {
  observer_.on_tls_refusal(place, why);
}

void GatewayDriver::tls_behind(std::chrono::milliseconds missed) {
  notice_stall(clock_());
  is_tls_behind_ = true;
  hand_in(gateway::Stalled{missed}, clock_());
  carry_out_actions();
}

void GatewayDriver::tls_drained() {
  is_tls_behind_ = false;
  clients_.read_all();
}

}  // namespace mbgate::io

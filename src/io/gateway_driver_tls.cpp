// SPDX-License-Identifier: Apache-2.0
// Clients of listeners with TLS. To the machine they are as any others.
#include <sys/socket.h>

#include <algorithm>

#include "io/gateway_driver.hpp"

namespace mbgate::io {

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
  const std::size_t waiting =
      std::max(arrival.bytes_waiting, is_behind() ? unread_bytes(socket.native_handle()) : 0);
  const gateway::ClientId id = clients_.add(std::move(socket));
  clients_.find(id)->set_relayed();
  connected(id, {arrival.place.listener, arrival.place.address, waiting, arrival.role});
}

void GatewayDriver::tls_refused(const TlsPlace& place, const std::string& why) {
  observer_.on_tls_refusal(place, why);
}

void GatewayDriver::tls_ended(const TlsPlace& place, const std::string& why) {
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

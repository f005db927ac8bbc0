// SPDX-License-Identifier: Apache-2.0
#include "io/tls/tls_door.hpp"

#include <algorithm>
#include <fmt/core.h>
#include <numeric>
#include <utility>

#include "io/clock.hpp"

namespace mbgate::io {

void TlsDoor::use(ListenerContexts contexts) {
  contexts_ = std::move(contexts);
  if (!front_ && !contexts_.empty()) {
    front_ = std::make_unique<TlsFront>(context_, *this);
  }
  if (front_) {
    front_->judge_again(contexts_);
  }
}

void TlsDoor::take(gateway::ListenerId number, const gateway::Settings& settings,
                   AcceptedClient client) {
  const gateway::ListenerSettings& listener = settings.listener(number);
  const TlsPlace place{number, address_of(client.peer), next_handshake_++};
  const auto context = contexts_.find(number);
  const std::string why = context == contexts_.end() || !front_ ? "there is no certificate"
                                                                : begin(place, listener.handshakes);
  if (!why.empty()) {
    events_.tls_refused(place, why);
    return;
  }
  const auto protocol = client.peer.protocol();
  front_->take({place, sys::UniqueFd(client.socket.release()), protocol, context->second,
                listener.handshakes});
}

// Who may begin none has nobody else's place: the rates come first.
std::string TlsDoor::begin(const TlsPlace& place, const gateway::HandshakeSettings& limits) {
  const bus::Instant at = now();
  OfListener& listener = listeners_[place.listener];
  std::erase_if(listener.clients, [at](const auto& it) {
    return it.second.under_way == 0 && it.second.begun.is_rested(at);
  });
  const routing::ClientAddress counted = place.address.counted_as();
  OfClient& client = listener.clients[counted];
  if (!client.begun.has_room(limits.per_second_for_one_client, at)) {
    return "too many handshakes of one client (max_handshakes_per_second_per_client)";
  }
  if (!listener.begun.has_room(limits.per_second, at)) {
    return "too many handshakes (max_handshakes_per_second)";
  }
  if (client.under_way >= limits.for_one_client &&
      !make_room(listener, &counted, "max_handshakes_per_client")) {
    return "too many handshakes of one client at a time (max_handshakes_per_client)";
  }
  if (listener.under_way.size() >= limits.at_a_time &&
      !make_room(listener, nullptr, "max_handshakes")) {
    return "too many handshakes at a time (max_handshakes)";
  }
  client.begun.take(limits.per_second_for_one_client, at);
  listener.begun.take(limits.per_second, at);
  note_begun(place);
  return {};
}

bool TlsDoor::make_room(OfListener& listener, const routing::ClientAddress* client,
                        const char* limit) {
  const auto oldest = std::ranges::find_if(listener.under_way, [client](const auto& it) {
    const Handshake& handshake = it.second;
    return !handshake.has_greeted && (client == nullptr || handshake.client == *client);
  });
  if (oldest == listener.under_way.end()) {
    return false;
  }
  front_->let_go(
      oldest->first,
      fmt::format("closed for another client, because no ClientHello had come ({})", limit));
  note_ended(listener, oldest->first);
  return true;
}

std::size_t TlsDoor::under_way() const {
  return std::accumulate(
      listeners_.begin(), listeners_.end(), std::size_t{0},
      [](std::size_t sum, const auto& listener) { return sum + listener.second.under_way.size(); });
}

// One that was let go may have greeted before it heard of that: it stays, and counts again.
void TlsDoor::tls_greeted(const TlsPlace& place) { note_begun(place).has_greeted = true; }

void TlsDoor::tls_arrived(TlsArrival arrival) {
  note_ended(listeners_[arrival.place.listener], arrival.place.handshake);
  events_.tls_arrived(std::move(arrival));
}

void TlsDoor::tls_refused(const TlsPlace& place, const std::string& why) {
  note_ended(listeners_[place.listener], place.handshake);
  events_.tls_refused(place, why);
}

TlsDoor::Handshake& TlsDoor::note_begun(const TlsPlace& place) {
  OfListener& listener = listeners_[place.listener];
  const routing::ClientAddress client = place.address.counted_as();
  const auto [handshake, is_new] = listener.under_way.try_emplace(place.handshake, client);
  if (is_new) {
    ++listener.clients[client].under_way;
  }
  return handshake->second;
}

void TlsDoor::note_ended(OfListener& listener, std::uint64_t handshake) {
  if (const auto ended = listener.under_way.find(handshake); ended != listener.under_way.end()) {
    --listener.clients[ended->second.client].under_way;
    listener.under_way.erase(ended);
  }
}

}  // namespace mbgate::io

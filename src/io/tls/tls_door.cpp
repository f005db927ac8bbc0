// SPDX-License-Identifier: Apache-2.0
#include "io/tls/tls_door.hpp"

#include <numeric>
#include <utility>

#include "io/clock.hpp"

namespace mbgate::io {
namespace {

bool has_room(const gateway::SecondRate& rate, unsigned per_second, bus::Instant at) {
  return per_second == 0 || rate.next(per_second, at) <= at;
}

void take_place(gateway::SecondRate& rate, unsigned per_second, bus::Instant at) {
  if (per_second > 0) {
    rate.take(per_second, at);
  }
}

}  // namespace

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
  const TlsPlace place{number, client.address()};
  const auto context = contexts_.find(number);
  const std::string why = context == contexts_.end() || !front_ ? "there is no certificate"
                                                                : begin(place, listener.handshakes);
  if (!why.empty()) {
    events_.tls_refused(place, why);
    return;
  }
  const auto protocol = client.peer.protocol();
  front_->take({place, UniqueFd(client.socket.release()), protocol, context->second,
                listener.handshakes.timeout});
}

std::string TlsDoor::begin(const TlsPlace& place, const gateway::HandshakeSettings& limits) {
  const bus::Instant at = now();
  OfListener& listener = listeners_[place.listener];
  std::erase_if(listener.clients, [at](const auto& it) {
    return it.second.under_way == 0 && it.second.begun.is_rested(at);
  });
  if (listener.under_way >= limits.at_a_time) {
    return "too many handshakes at a time (max_handshakes)";
  }
  OfClient& client = listener.clients[place.address];
  if (client.under_way >= limits.for_one_client) {
    return "too many handshakes of one client at a time (max_handshakes_per_client)";
  }
  if (!has_room(client.begun, limits.per_second_for_one_client, at)) {
    return "too many handshakes of one client (max_handshakes_per_second_per_client)";
  }
  if (!has_room(listener.begun, limits.per_second, at)) {
    return "too many handshakes (max_handshakes_per_second)";
  }
  take_place(client.begun, limits.per_second_for_one_client, at);
  take_place(listener.begun, limits.per_second, at);
  ++client.under_way;
  ++listener.under_way;
  return {};
}

std::size_t TlsDoor::under_way() const {
  return std::accumulate(
      listeners_.begin(), listeners_.end(), std::size_t{0},
      [](std::size_t sum, const auto& listener) { return sum + listener.second.under_way; });
}

void TlsDoor::tls_arrived(TlsArrival arrival) {
  note_ended(arrival.place);
  events_.tls_arrived(std::move(arrival));
}

void TlsDoor::tls_refused(const TlsPlace& place, const std::string& why) {
  note_ended(place);
  events_.tls_refused(place, why);
}

void TlsDoor::note_ended(const TlsPlace& place) {
  OfListener& listener = listeners_[place.listener];
  const auto client = listener.clients.find(place.address);
  if (client != listener.clients.end() && client->second.under_way > 0) {
    --client->second.under_way;
    --listener.under_way;
  }
}

}  // namespace mbgate::io

// SPDX-License-Identifier: Apache-2.0
#include "io/tls/tls_door.hpp"

#include <numeric>
#include <utility>

namespace mbgate::io {
namespace {

std::size_t sum_of(const std::map<routing::ClientAddress, std::size_t>& counts) {
  return std::accumulate(counts.begin(), counts.end(), std::size_t{0},
                         [](std::size_t sum, const auto& count) { return sum + count.second; });
}

}  // namespace

void TlsDoor::use(TlsContexts contexts) {
  contexts_ = std::move(contexts);
  if (front_) {
    front_->judge_again(contexts_);
  } else if (!contexts_.empty()) {
    front_ = std::make_unique<TlsFront>(context_, *this);
  }
}

void TlsDoor::take(gateway::ListenerId number, const gateway::Settings& settings,
                   AcceptedClient client) {
  const gateway::ListenerSettings& listener = settings.listener(number);
  const TlsPlace place{number, client.address()};
  const std::string& name = settings.tls[*listener.tls].name;
  const auto context = contexts_.find(name);
  const std::string why = context == contexts_.end() || !front_
                              ? "there is no certificate"
                              : objection(place, listener.handshakes);
  if (!why.empty()) {
    events_.tls_refused(place, why);
    return;
  }
  ++under_way_[number][place.address];
  const auto protocol = client.peer.protocol();
  front_->take({place, UniqueFd(client.socket.release()), protocol, name, context->second,
                listener.handshakes.timeout});
}

std::string TlsDoor::objection(const TlsPlace& place,
                               const gateway::HandshakeSettings& limits) const {
  const auto listener = under_way_.find(place.listener);
  if (listener == under_way_.end()) {
    return {};
  }
  if (sum_of(listener->second) >= limits.at_a_time) {
    return "too many handshakes at a time (max_handshakes)";
  }
  const auto own = listener->second.find(place.address);
  return own != listener->second.end() && own->second >= limits.for_one_client
             ? "too many handshakes of one client at a time (max_handshakes_per_client)"
             : std::string();
}

std::size_t TlsDoor::under_way() const {
  std::size_t sum = 0;
  for (const auto& [number, counts] : under_way_) {
    sum += sum_of(counts);
  }
  return sum;
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
  auto& counts = under_way_[place.listener];
  const auto count = counts.find(place.address);
  if (count != counts.end() && --count->second == 0) {
    counts.erase(count);
  }
}

}  // namespace mbgate::io

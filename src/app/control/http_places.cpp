// SPDX-License-Identifier: Apache-2.0
#include "app/control/http_places.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <tuple>
#include <utility>

namespace mbgate::app {
namespace {

/// A connection that has not asked by then counts as idle.
constexpr std::chrono::seconds kNewFor{1};

}  // namespace

HttpPlaces::Place::Place(std::string client, Close close)
    : client_(std::move(client)), close_(std::move(close)) {
  enter(State::new_here);
}

void HttpPlaces::Place::enter(State state) {
  state_ = state;
  since_ = std::chrono::steady_clock::now();
}

HttpPlaces::Place::State HttpPlaces::Place::state_at(
    std::chrono::steady_clock::time_point now) const {
  return state_ == State::new_here && now - since_ >= kNewFor ? State::waits : state_;
}

HttpPlaces::Held HttpPlaces::held() {
  std::erase_if(places_, [](const auto& place) { return place.expired(); });
  Held held;
  std::ranges::transform(places_, std::back_inserter(held),
                         [](const auto& place) { return place.lock(); });
  return held;
}

std::shared_ptr<HttpPlaces::Place> HttpPlaces::displaced_for(const std::string& client,
                                                             const Held& held) const {
  std::map<std::string, std::size_t> counts;
  std::size_t most = 0;
  for (const auto& place : held) {
    most = std::max(most, ++counts[place->client_]);
  }
  const std::size_t own = counts[client];
  const bool is_own_matter = own >= most_of_one_ || own == most;
  Held crowd;
  std::ranges::copy_if(held, std::back_inserter(crowd), [&](const auto& place) {
    const bool is_among = is_own_matter ? place->client_ == client : counts[place->client_] == most;
    return is_among && place->state_ != Place::State::commanded;
  });
  const auto now = std::chrono::steady_clock::now();
  const auto first = std::ranges::min_element(crowd, {}, [&](const auto& place) {
    return std::tuple(place->state_at(now), place->since_);
  });
  return first == crowd.end() ? nullptr : *first;
}

std::shared_ptr<HttpPlaces::Place> HttpPlaces::take(const std::string& client, Close close) {
  const Held held = this->held();
  const auto own = std::ranges::count(held, client, &Place::client_);
  if (held.size() >= most_ || static_cast<std::size_t>(own) >= most_of_one_) {
    const auto displaced = displaced_for(client, held);
    if (!displaced) {
      return nullptr;
    }
    std::erase_if(places_, [&](const auto& place) { return place.lock() == displaced; });
    displaced->close_();
  }
  auto place = std::make_shared<Place>(client, std::move(close));
  places_.push_back(place);
  return place;
}

}  // namespace mbgate::app

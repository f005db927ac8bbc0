// SPDX-License-Identifier: Apache-2.0
#include "io/tls/tls_front.hpp"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <exception>
#include <utility>

#include "io/blocking_calls.hpp"
#include "io/clock.hpp"
#include "io/supervise.hpp"

namespace mbgate::io {
namespace {

/// With the machine's own times at the end of the process it makes less than 2 s.
constexpr std::chrono::milliseconds kLastBytes{150};

}  // namespace

TlsFront::TlsFront(boost::asio::io_context& home, TlsEvents& events)
    : home_(home),
      events_(events),
      work_(io_.get_executor()),
      hangups_(io_,
               [this](std::uint64_t key, Hangup /*hangup*/) {
                 if (const auto entry = clients_.find(key); entry != clients_.end()) {
                   entry->second.client->end();
                 }
               }),
      closings_(io_,
                [this](std::uint64_t key, Hangup /*hangup*/) {
                  if (const auto entry = clients_.find(key); entry != clients_.end()) {
                    entry->second.client->linger();
                  }
                }),
      heartbeat_(io_, [this] { look_for_stall(); }),
      shared_{io_, hangups_, closings_, [this] { look_for_stall(); }},
      thread_([this] { run(); }) {}

TlsFront::~TlsFront() {
  boost::asio::post(io_, [this] { finish(); });
  thread_.join();
}

void TlsFront::run() {
  block_signals();
  try {
    io_.run();
  } catch (...) {
    // Whoever runs the machine ends the process, and says why.
    boost::asio::post(home_, [error = std::current_exception()] { std::rethrow_exception(error); });
  }
}

template <typename Told>
void TlsFront::tell(Told told) {
  boost::asio::post(home_, [&events = events_, told = std::move(told)]() mutable { told(events); });
}

void TlsFront::take(TlsCandidate candidate) {
  boost::asio::post(io_, [this, candidate = std::move(candidate)]() mutable {
    boost::asio::ip::tcp::socket socket(io_);
    boost::system::error_code error;
    socket.assign(candidate.protocol, candidate.socket.get(), error);
    if (error || is_ending_) {
      tell([place = candidate.place, why = error.message()](TlsEvents& events) {
        events.tls_refused(place, why);
      });
      return;
    }
    candidate.socket.release();
    const std::uint64_t key = candidate.place.handshake;
    clients_[key] = {
        std::make_shared<TlsClient>(shared_, key, std::move(candidate.context), std::move(socket)),
        candidate.place};
    heartbeat_.beat_while(true);
    supervise(io_, serve(key, candidate.limits), "TLS of a client");
  });
}

void TlsFront::let_go(std::uint64_t handshake, std::string why) {
  boost::asio::post(io_, [this, handshake, why = std::move(why)] {
    const auto entry = clients_.find(handshake);
    if (entry != clients_.end() && !entry->second.client->has_greeted()) {
      entry->second.client->end(why);
    }
  });
}

std::function<void()> TlsFront::teller_of_greeting(const TlsPlace& place) {
  return [this, place] { tell([place](TlsEvents& events) { events.tls_greeted(place); }); };
}

boost::asio::awaitable<void> TlsFront::serve(std::uint64_t key, gateway::HandshakeSettings limits) {
  const std::shared_ptr<TlsClient> client = clients_[key].client;
  const auto failure =
      co_await TlsClient::shake_hands(client, limits, teller_of_greeting(clients_[key].place));
  look_for_stall();
  if (failure) {
    co_await TlsClient::drain_and_end(client);  // it still counts among those that shake hands
    tell([place = clients_[key].place, why = *failure](TlsEvents& events) {
      events.tls_refused(place, "no TLS handshake: " + why);
    });
  } else if (hand_over(clients_[key])) {
    co_await TlsClient::carry(client);
    if (!client->complaint().empty()) {
      tell([place = clients_[key].place, why = client->complaint()](TlsEvents& events) {
        events.tls_refused(place, "its TLS was ended: " + why);
      });
    }
  }
  forget(key);
}

// A reload may have come during the handshake, which went by what was in force at its begin.
bool TlsFront::hand_over(Entry& entry) {
  if (const auto why = objection(entry)) {
    tell([place = entry.place, why = *why](TlsEvents& events) { events.tls_refused(place, why); });
    entry.client->end();
    return false;
  }
  TlsArrival arrival{entry.place, entry.client->make_pair(), entry.client->role()};
  if (!arrival.socket.is_open()) {
    tell([place = entry.place](TlsEvents& events) {
      events.tls_refused(place, "no file descriptor is left for it");
    });
    entry.client->end();
    return false;
  }
  const bool brings_old = entry.is_old && entry.client->drain() > 0;
  arrival.since = brings_old ? bus::Instant::min() : now();
  tell([arrival = std::move(arrival)](TlsEvents& events) mutable {
    events.tls_arrived(std::move(arrival));
  });
  return true;
}

void TlsFront::judge_again(ListenerContexts contexts) {
  boost::asio::post(io_, [this, contexts = std::move(contexts)]() mutable {
    contexts_.swap(contexts);
    for (const auto& [listener, old] : contexts) {
      const auto is_old = [&old = old](const auto& it) { return it.second == old; };
      if (std::ranges::none_of(contexts_, is_old)) {
        old->drop_key();
      }
    }
    judge_all();
  });
}

void TlsFront::judge_all() {
  for (const auto& [key, entry] : clients_) {
    if (!entry.client->has_pair()) {
      continue;
    }
    if (const auto why = objection(entry)) {
      tell(
          [place = entry.place, why = *why](TlsEvents& events) { events.tls_refused(place, why); });
      entry.client->end();
    }
  }
}

std::optional<std::string> TlsFront::objection(const Entry& entry) const {
  const auto context = contexts_.find(entry.place.listener);
  if (context == contexts_.end()) {
    return "its listener has no TLS any more";
  }
  auto why = entry.client->objection(*context->second);
  if (why) {
    why->insert(0, "its certificate is not accepted any more: ");
  }
  return why;
}

// Before anything goes on that has waited meanwhile.
void TlsFront::look_for_stall() {
  const auto missed = heartbeat_.missed(now());
  if (!missed) {
    return;
  }
  tell([missed = *missed](TlsEvents& events) { events.tls_behind(missed); });
  for (auto& [key, entry] : clients_) {
    if (entry.client->has_pair()) {
      entry.client->drain();
    } else {
      entry.is_old = true;
    }
  }
  tell([](TlsEvents& events) { events.tls_drained(); });
}

void TlsFront::forget(std::uint64_t key) {
  clients_.erase(key);
  heartbeat_.beat_while(!clients_.empty());
  if (is_ending_ && clients_.empty()) {
    io_.stop();
  }
}

void TlsFront::finish() {
  is_ending_ = true;
  if (clients_.empty()) {
    io_.stop();
    return;
  }
  const auto limit = std::make_shared<boost::asio::steady_timer>(io_, kLastBytes);
  limit->async_wait([this, limit](const boost::system::error_code&) { io_.stop(); });
}

}  // namespace mbgate::io

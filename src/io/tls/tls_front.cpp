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
                 if (const auto client = client_of(key)) {
                   client->end();
                 }
               }),
      closings_(io_,
                [this](std::uint64_t key, Hangup /*hangup*/) {
                  if (const auto client = client_of(key)) {
                    client->linger();
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

void TlsFront::refuse(const TlsPlace& place, const std::string& why) {
  tell([place, why](TlsEvents& events) { events.tls_refused(place, why); });
}

std::shared_ptr<TlsClient> TlsFront::client_of(std::uint64_t key) const {
  const auto entry = clients_.find(key);
  return entry == clients_.end() ? nullptr : entry->second.client;
}

void TlsFront::take(TlsCandidate candidate) {
  boost::asio::post(io_, [this, candidate = std::move(candidate)]() mutable {
    boost::asio::ip::tcp::socket socket(io_);
    boost::system::error_code error;
    socket.assign(candidate.protocol, candidate.socket.get(), error);
    if (error || is_ending_) {
      refuse(candidate.place, error.message());
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
    const auto client = client_of(handshake);
    if (client && !client->has_greeted()) {
      client->end(why);
    }
  });
}

boost::asio::awaitable<void> TlsFront::serve(std::uint64_t key, gateway::HandshakeSettings limits) {
  Entry& entry = clients_[key];
  const std::shared_ptr<TlsClient> client = entry.client;
  const std::function<void()> greeted = [this, place = entry.place] {
    tell([place](TlsEvents& events) { events.tls_greeted(place); });
  };
  const auto failure = co_await client->shake_hands(limits, greeted);
  look_for_stall();
  if (failure) {
    co_await client->drain_and_end();  // it still counts among those that shake hands
    refuse(entry.place, "no TLS handshake: " + *failure);
  } else if (hand_over(entry)) {
    co_await client->carry();
    if (!client->complaint().empty()) {
      refuse(entry.place, "its TLS was ended: " + client->complaint());
    }
  }
  forget(key);
}

// A reload may have come during the handshake, which went by what was in force at its begin.
bool TlsFront::hand_over(Entry& entry) {
  if (!judge(entry)) {
    return false;
  }
  TlsArrival arrival{entry.place, entry.client->make_pair(), entry.client->role()};
  if (!arrival.socket.is_open()) {
    refuse(entry.place, "no file descriptor is left for it");
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
      const auto is_old = [&context = old](const auto& it) { return it.second == context; };
      if (std::ranges::none_of(contexts_, is_old)) {
        old->drop_key();
      }
    }
    for (const auto& [key, entry] : clients_) {
      if (entry.client->has_pair()) {
        judge(entry);
      }
    }
  });
}

bool TlsFront::judge(const Entry& entry) {
  std::string why = "its listener has no TLS any more";
  if (const auto context = contexts_.find(entry.place.listener); context != contexts_.end()) {
    const auto objection = entry.client->objection(*context->second);
    if (!objection) {
      return true;
    }
    why = "its certificate is not accepted any more: " + *objection;
  }
  refuse(entry.place, why);
  entry.client->end();
  return false;
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

// SPDX-License-Identifier: Apache-2.0
#include "app/listeners.hpp"

#include <algorithm>
#include <fmt/core.h>
#include <utility>

#include "io/supervise.hpp"

namespace mbgate::app {

using gateway::ListenerId;
using gateway::ListenerSettings;

Listeners::Listeners(boost::asio::io_context& context, Log& log, Take take, Bind bind,
                     ListenerWaits waits)
    : context_(context),
      log_(log),
      take_(std::move(take)),
      bind_(std::move(bind)),
      waits_(waits),
      timer_(context) {}

bool Listeners::begin(const std::vector<ListenerSettings>& listeners,
                      std::vector<InheritedSocket> inherited) {
  bool all = true;
  for (std::size_t i = 0; i < listeners.size(); ++i) {
    all = listen(static_cast<ListenerId>(i), listeners[i], inherited) && all;
  }
  for (const auto& socket : inherited) {
    if (socket.fd.is_open()) {
      log_.write(
          Level::warning,
          fmt::format("the socket \"{}\" from systemd is not used: no [[listen]] has this name",
                      socket.name),
          {.id = message_id::kSocketUnknown});
    }
  }
  return all;
}

bool Listeners::listen(ListenerId id, const ListenerSettings& listener,
                       std::vector<InheritedSocket>& inherited) {
  bool adopted = false;
  bool all = true;
  for (auto& socket : inherited) {
    if (socket.fd.is_open() && socket.name == listener.name) {
      adopted = true;
      inherited_.insert(id);
      all = keep(id, listener, io::adopt_listener(context_, listener, std::move(socket.fd))) && all;
    }
  }
  if (adopted) {
    return all;
  }
  auto stored = stored_ != nullptr ? stored_->claim(listener) : sys::UniqueFd();
  return keep(id, listener,
              stored.is_open() ? io::adopt_listener(context_, listener, std::move(stored))
                               : bind_(context_, listener));
}

bool Listeners::keep(ListenerId id, const ListenerSettings& listener,
                     Result<Acceptor, io::ListenFailure> acceptor) {
  if (acceptor) {
    add(id, listener, *std::move(acceptor));
    return true;
  }
  const auto& failure = acceptor.error();
  if (!failure.absent) {
    refuse(listener, failure);
    return false;
  }
  log_.write(Level::warning, fmt::format("{}; {}", failure.why, waits_.promise),
             {.id = message_id::kListenerWaits, .listener = listener.name});
  waiting_.push_back({id, listener, failure.why});
  return true;
}

void Listeners::refuse(const ListenerSettings& listener, const io::ListenFailure& failure) {
  is_denied_ = is_denied_ || failure.denied;
  const MessageId id = failure.denied ? message_id::kDenied : message_id::kListenerRefused;
  log_.write(Level::error, failure.why, {.id = id, .listener = listener.name});
  refusals_.push_back(failure.why);
}

void Listeners::add(ListenerId id, const ListenerSettings& listener, Acceptor acceptor) {
  Line line{fmt::format("listening {} {}", listener.name, io::to_text(acceptor.local_endpoint())),
            {.id = message_id::kListening, .listener = listener.name}};
  if (stored_ != nullptr && !inherited_.contains(id)) {
    stored_->keep(listener, acceptor);
  }
  take_(id, std::move(acceptor));
  if (started_) {
    log_.print(std::move(line.text), line.topic);
  } else {
    lines_.push_back(std::move(line));
  }
}

void Listeners::start() {
  started_ = true;
  for (auto& line : std::exchange(lines_, {})) {
    log_.print(std::move(line.text), line.topic);
  }
  keep_trying();
}

void Listeners::keep_trying() {
  if (!waiting_.empty() && !std::exchange(trying_, true)) {
    io::supervise(context_, try_on(), "listeners");
  }
}

bool Listeners::stays(ListenerId id, const ListenerSettings& old,
                      const ListenerSettings& next) const {
  const bool same = old.address == next.address && old.port == next.port &&
                    old.freebind == next.freebind && old.tcp == next.tcp;
  return !old.is_gone && !next.is_gone && (same || inherited_.contains(id));
}

// An address can be had once at a time: what goes makes room before anything is bound. Sockets from
// systemd go last: they make no room, because systemd holds them too, and could not be had again.
bool Listeners::reload(const std::vector<ListenerSettings>& old,
                       const std::vector<ListenerSettings>& next, const Drop& drop) {
  std::vector<std::size_t> dropped;
  std::vector<std::size_t> wanted;
  std::vector<ListenerId> inherited;
  for (std::size_t i = 0; i < next.size(); ++i) {
    const auto id = static_cast<ListenerId>(i);
    const bool was = i < old.size() && !old[i].is_gone;
    if (was && stays(id, old[i], next[i])) {
      continue;
    }
    if (was && inherited_.contains(id)) {
      inherited.push_back(id);
    } else if (was) {
      dropped.push_back(i);
      leave(id, old[i], drop);
    }
    if (!next[i].is_gone) {
      wanted.push_back(i);
    }
  }
  refusals_.clear();
  const bool all = open_all(wanted, next);
  if (all) {
    for (const ListenerId id : inherited) {
      drop(id);
      inherited_.erase(id);
    }
  } else {
    for (const std::size_t i : dropped) {
      const auto id = static_cast<ListenerId>(i);
      if (!keep(id, old[i], bind_(context_, old[i]))) {
        waiting_.push_back({id, old[i], {}});  // somebody was quick
      }
    }
  }
  keep_trying();
  return all;
}

void Listeners::leave(ListenerId id, const ListenerSettings& listener, const Drop& drop) {
  drop(id);
  if (stored_ != nullptr) {
    stored_->end(listener);
  }
  std::erase_if(waiting_, [id](const Waiting& waiting) { return waiting.id == id; });
}

// All of these, or none.
bool Listeners::open_all(const std::vector<std::size_t>& wanted,
                         const std::vector<ListenerSettings>& settings) {
  std::vector<Bound> bound;
  bound.reserve(wanted.size());
  bool all = true;
  for (const std::size_t i : wanted) {
    bound.push_back(bind_(context_, settings[i]));
    if (!bound.back() && !bound.back().error().absent) {
      refuse(settings[i], bound.back().error());
      all = false;
    }
  }
  for (std::size_t i = 0; all && i < wanted.size(); ++i) {
    keep(static_cast<ListenerId>(wanted[i]), settings[wanted[i]], std::move(bound[i]));
  }
  return all;
}

void Listeners::stop() {
  waiting_.clear();
  timer_.cancel();
}

bool Listeners::try_again(Waiting& waiting) {
  auto acceptor = bind_(context_, waiting.listener);
  if (acceptor) {
    add(waiting.id, waiting.listener, *std::move(acceptor));
    return true;
  }
  // The address may have come with somebody else on its port. That ends nobody who is served.
  if (std::exchange(waiting.said, acceptor.error().why) != acceptor.error().why) {
    log_.write(Level::warning, acceptor.error().why + "; it is tried again",
               {.id = message_id::kListenerWaits, .listener = waiting.listener.name});
  }
  return false;
}

boost::asio::awaitable<void> Listeners::try_on() {
  auto wait = waits_.first;
  while (!waiting_.empty()) {
    timer_.expires_after(wait);
    const auto [error] = co_await timer_.async_wait(io::kAsTuple);
    if (error) {
      break;
    }
    std::erase_if(waiting_, [this](Waiting& waiting) { return try_again(waiting); });
    wait = std::min(2 * wait, waits_.longest);
  }
  trying_ = false;
}

}  // namespace mbgate::app

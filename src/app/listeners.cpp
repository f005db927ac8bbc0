// SPDX-License-Identifier: Apache-2.0
#include "app/listeners.hpp"

#include <algorithm>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>
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
      log_.write(Level::warning,
                 "the socket \"" + socket.name + "\" from systemd has the name of no listener");
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
      all = keep(id, listener, io::adopt_listener(context_, listener, std::move(socket.fd))) && all;
    }
  }
  return adopted ? all : keep(id, listener, bind_(context_, listener));
}

bool Listeners::keep(ListenerId id, const ListenerSettings& listener,
                     Result<Acceptor, io::ListenFailure> acceptor) {
  if (acceptor) {
    add(id, listener, *std::move(acceptor));
    return true;
  }
  const auto& failure = acceptor.error();
  if (!failure.absent) {
    log_.write(Level::error, failure.why);
    return false;
  }
  log_.write(Level::warning, failure.why +
                                 "; it is tried again until this machine has the address "
                                 "(freebind = true listens at once)");
  waiting_.push_back({id, listener, failure.why});
  return true;
}

void Listeners::add(ListenerId id, const ListenerSettings& listener, Acceptor acceptor) {
  std::string line = "listening " + listener.name + " " + io::to_text(acceptor.local_endpoint());
  take_(id, std::move(acceptor));
  if (started_) {
    log_.print(std::move(line));
  } else {
    lines_.push_back(std::move(line));
  }
}

void Listeners::start() {
  started_ = true;
  for (auto& line : std::exchange(lines_, {})) {
    log_.print(std::move(line));
  }
  if (!waiting_.empty()) {
    io::supervise(context_, try_on(), "listeners");
  }
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
    log_.write(Level::warning, acceptor.error().why + "; it is tried again");
  }
  return false;
}

boost::asio::awaitable<void> Listeners::try_on() {
  auto wait = waits_.first;
  while (!waiting_.empty()) {
    timer_.expires_after(wait);
    const auto [error] =
        co_await timer_.async_wait(boost::asio::as_tuple(boost::asio::use_awaitable));
    if (error) {
      co_return;
    }
    std::erase_if(waiting_, [this](Waiting& waiting) { return try_again(waiting); });
    wait = std::min(2 * wait, waits_.longest);
  }
}

}  // namespace mbgate::app

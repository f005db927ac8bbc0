// SPDX-License-Identifier: Apache-2.0
#include "app/http_listeners.hpp"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

#include "io/clients/listening_socket.hpp"

namespace mbgate::app {
namespace {

using boost::asio::ip::tcp;
using gateway::ListenerId;
using gateway::ListenerSettings;

/// In the journal, and as FileDescriptorName=.
constexpr const char* kHttp = "http";

/// Whatever is missing may come: another process ends, or somebody permits it.
Result<tcp::acceptor, io::ListenFailure> bind_http(boost::asio::io_context& context,
                                                   const ListenerSettings& listener) {
  auto bound = io::bind_listener(context, listener);
  if (!bound) {
    auto failure = bound.error();
    failure.absent = true;
    return failure;
  }
  return bound;
}

ListenerSettings http_listener(const routing::ListenAddress& listen) {
  ListenerSettings listener;
  listener.name = kHttp;
  listener.address = listen.address.to_text();
  listener.port = listen.port;
  return listener;
}

/// Those of this name, which are no longer among the others then.
std::vector<InheritedSocket> take_named(std::vector<InheritedSocket>& sockets,
                                        const std::string& name) {
  const auto named =
      std::ranges::stable_partition(sockets, [&](const auto& it) { return it.name != name; });
  std::vector<InheritedSocket> taken(std::make_move_iterator(named.begin()),
                                     std::make_move_iterator(named.end()));
  sockets.erase(named.begin(), named.end());
  return taken;
}

}  // namespace

std::vector<ListenerSettings> http_listeners(std::vector<ListenerSettings> old,
                                             const gateway::HttpSettings& settings) {
  std::vector<ListenerSettings> next = std::move(old);
  for (auto& listener : next) {
    listener.is_gone = true;
  }
  for (const auto& listen : settings.listen) {
    const ListenerSettings wanted = http_listener(listen);
    const auto same = std::ranges::find_if(next, [&](const ListenerSettings& it) {
      return it.is_gone && it.address == wanted.address && it.port == wanted.port;
    });
    if (same != next.end()) {
      same->is_gone = false;
    } else {
      next.push_back(wanted);
    }
  }
  return next;
}

HttpListeners::HttpListeners(boost::asio::io_context& context, Log& log, Control& control)
    : log_(log),
      control_(control),
      listeners_(context, log,
                 [this](ListenerId id, tcp::acceptor acceptor) {
                   const std::string failure = control_.listen_on(id, std::move(acceptor));
                   if (!failure.empty()) {
                     log_.write(Level::error, failure, {.id = message_id::kControlFailed});
                   }
                 },
                 bind_http, {.promise = "it is tried again"}) {}

void HttpListeners::take(const gateway::Settings& settings,
                         std::vector<InheritedSocket>& inherited) {
  if (std::ranges::find(settings.listeners, kHttp, &ListenerSettings::name) ==
      settings.listeners.end()) {
    inherited_ = take_named(inherited, kHttp);
  }
  is_inherited_ = !inherited_.empty();
}

void HttpListeners::begin(const gateway::HttpSettings& settings) {
  control_.apply(settings);
  if (is_inherited_) {
    now_.emplace_back().name = kHttp;
  } else {
    now_ = http_listeners({}, settings);
  }
  // False where a socket from systemd is none of TCP; the journal says it.
  static_cast<void>(listeners_.begin(now_, std::exchange(inherited_, {})));
}

// An address can be had once at a time, and they are closed on the other thread.
void HttpListeners::make_room(const gateway::HttpSettings& settings,
                              const std::function<void()>& then) {
  if (is_inherited_) {
    then();
    return;
  }
  const auto after = http_listeners(now_, settings);
  auto fewer = now_;
  for (std::size_t i = 0; i < fewer.size(); ++i) {
    fewer[i].is_gone = fewer[i].is_gone || (after[i].is_gone && fewer[i].port != 0);
  }
  const bool has_room =
      std::ranges::equal(now_, fewer, {}, &ListenerSettings::is_gone, &ListenerSettings::is_gone);
  if (has_room) {
    then();
    return;
  }
  change(fewer);
  control_.when_left(then);
}

void HttpListeners::reload(const gateway::HttpSettings& settings) {
  control_.apply(settings);
  if (is_inherited_ || has_stopped_) {
    return;
  }
  change(http_listeners(now_, settings));
  for (std::size_t i = 0; i < now_.size(); ++i) {
    if (now_[i].is_gone) {
      control_.close_clients(static_cast<ListenerId>(i));
    }
  }
}

void HttpListeners::change(const std::vector<ListenerSettings>& next) {
  static_cast<void>(listeners_.reload(now_, next, [this](ListenerId id) { control_.leave(id); }));
  now_ = next;
}

void HttpListeners::stop() {
  has_stopped_ = true;
  listeners_.stop();
}

}  // namespace mbgate::app

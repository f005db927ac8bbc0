// SPDX-License-Identifier: Apache-2.0
#include "gateway/clients/client_session.hpp"

#include <algorithm>

#include "base/assert.hpp"

namespace mbgate::gateway {

ClientSession::ClientSession(ClientId id, const ClientInfo& info, const ListenerSettings& listener,
                             Instant now)
    : answers(listener.ordered),
      last_activity(now),
      id_(id),
      info_(info),
      key_(key_of(info, listener)),
      listener_(&listener),
      rights_{listener.read_only.contains(info.address, info.role)},
      waits_since_(info.waits_since),
      ran_at_(now) {}

void ClientSession::adopt(const ListenerSettings& listener) {
  listener_ = &listener;
  rights_ = {listener.read_only.contains(info_.address, info_.role)};
}

Instant ClientSession::arrival_of(std::size_t unread, Instant now) {
  const Instant arrival = waits_since_.value_or(now);
  if (unread == 0) {
    waits_since_.reset();
    ran_at_ = now;
  }
  return arrival;
}

void ClientSession::stall(Instant since) {
  const bool is_read_to_the_end = half_closed_ && !paused_;
  if (!waits_since_ && !is_read_to_the_end) {
    // Of a client with TLS, what was not handed on yet does not lie in this socket.
    const bool lies_here = info_.role.kind == routing::ClientRole::Kind::none;
    waits_since_ = lies_here ? std::max(since, ran_at_) : since;
  }
}

void ClientSession::half_close() {
  half_closed_ = true;
  if (!paused_) {
    waits_since_.reset();  // the FIN was read, and so was everything before it
  }
}

std::optional<ClientSession::Reading> ClientSession::update_reading(Instant now) {
  // Who does not read its answers is not read either, but what was read may hold a stop.
  if ((answers.outstanding() >= kRequestsOutstanding) == paused_) {
    return std::nullopt;
  }
  paused_ = !paused_;
  waits_since_ = waits_since_.value_or(now);  // resumed: until the socket was read
  return paused_ ? Reading::pause : Reading::resume;
}

ClientSession::Overdue ClientSession::overdue(Instant now) const {
  if (may_have_asked()) {
    return Overdue::nothing;
  }
  if (partial_since && now >= *partial_since + listener_->frame_timeout) {
    return Overdue::within_request;
  }
  const bool may_be_idle = listener_->idle_timeout > Duration{0} && is_at_rest();
  return may_be_idle && now >= last_activity + listener_->idle_timeout ? Overdue::idle
                                                                       : Overdue::nothing;
}

std::optional<Instant> ClientSession::next_look(Instant now) const {
  if (may_have_asked()) {
    return std::nullopt;
  }
  std::optional<Instant> next;
  if (partial_since) {
    next = *partial_since + listener_->frame_timeout;
  }
  if (listener_->idle_timeout > Duration{0}) {
    const Instant active = is_at_rest() ? last_activity : now;
    next = bus::earlier(next, active + listener_->idle_timeout);
  }
  return next;
}

void ClientSession::note_partial(Instant now) {
  const bool is_partial = !input.empty() && !is_full();
  partial_since = is_partial ? std::optional(partial_since.value_or(now)) : std::nullopt;
}

AnswerId DueAnswers::open() {
  if (!ordered_) {
    ++open_;
    return AnswerId{0};
  }
  held_.emplace_back();
  return AnswerId{first_held_ + held_.size() - 1};
}

DueAnswers::Ready DueAnswers::close(AnswerId id, const std::optional<Answer>& answer,
                                    bus::Instant now) {
  Ready ready;
  const auto send = [&](const std::optional<Answer>& it) {
    if (it && now <= it->until) {
      ready.push_back(it->adu);
    }
  };
  if (!ordered_) {
    MBGATE_ASSERT(open_ > 0, "one answer for each request");
    --open_;
    send(answer);
  } else {
    const auto place = static_cast<std::size_t>(static_cast<std::uint64_t>(id) - first_held_);
    MBGATE_ASSERT(place < held_.size() && !held_[place].done, "one answer for each request");
    Held& held = held_[place];
    held.done = true;
    held.answer = answer;
    while (!held_.empty() && held_.front().done) {
      send(held_.front().answer);
      held_.pop_front();
      ++first_held_;
    }
  }
  unsent_ += ready.size();
  return ready;
}

void DueAnswers::drop_waiting() {
  for (Held& held : held_) {
    if (held.answer && !held.answer->is_stops) {
      held.answer.reset();
    }
  }
}

}  // namespace mbgate::gateway

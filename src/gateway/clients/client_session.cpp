// SPDX-License-Identifier: Apache-2.0
#include "gateway/clients/client_session.hpp"

#include <algorithm>

#include "gateway/limits.hpp"

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
      seen_empty_(now) {}

void ClientSession::adopt(const ListenerSettings& listener) {
  listener_ = &listener;
  rights_ = {listener.read_only.contains(info_.address, info_.role)};
}

Instant ClientSession::arrival_of(std::size_t bytes, std::size_t unread, Instant now) {
  const Instant arrival = pauses_.empty() ? now : pauses_.front().began;
  read_position_ += bytes;
  unread_ = unread;
  while (pauses_.size() > 1 && pauses_[1].position <= read_position_) {
    pauses_.erase(pauses_.begin());
  }
  if (unread == 0) {
    pauses_.clear();
    seen_empty_ = now;
  }
  return arrival;
}

void ClientSession::stall(Instant since) {
  const bool is_read_to_the_end = half_closed_ && !paused_;
  if (pauses_.empty() && !is_read_to_the_end) {
    // Of a client with TLS, what was not handed on yet does not lie in this socket.
    const bool lies_here = info_.role.kind == routing::ClientRole::Kind::none;
    const Instant ran = std::max(seen_empty_, input.reloaded());  // it did not stand still then
    pauses_.push_back({read_position_, lies_here ? std::max(since, ran) : since});
  }
}

void ClientSession::half_close() {
  half_closed_ = true;
  if (!paused_) {
    pauses_.clear();  // the FIN was read, and so was everything before it
  }
}

void ClientSession::end_hold(Instant now) {
  if (held_until && now >= *held_until) {
    held_until.reset();
    has_turn = true;
  }
}

std::optional<ClientSession::Reading> ClientSession::update_reading(Instant now) {
  // One more piece must still fit into the read-ahead.
  const bool enough = is_held_up() && input.size() + kClientReadSize > kReadAhead;
  if (enough == paused_) {
    return std::nullopt;
  }
  paused_ = enough;
  if (paused_) {
    // What is in the socket by now is as old as it was; what comes behind it counts from this
    // pause. Without room for another mark it counts as older still.
    if (pauses_.empty()) {
      pauses_.push_back({read_position_, now});
    } else if (pauses_.size() < kArrivalMarks) {
      pauses_.push_back({read_position_ + unread_, now});
    }
    return Reading::pause;
  }
  return Reading::resume;
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
    return held_until;
  }
  std::optional<Instant> next;
  if (partial_since) {
    next = *partial_since + listener_->frame_timeout;
  }
  if (listener_->idle_timeout > Duration{0}) {
    const Instant active = is_at_rest() ? last_activity : now;
    next = bus::earlier(next, active + listener_->idle_timeout);
  }
  return bus::earlier(next, held_until);
}

void ClientSession::note_partial(Instant now) {
  const bool is_partial = !input.empty() && !is_held_up();
  if (!is_partial) {
    partial_since.reset();
  } else if (!partial_since) {
    partial_since = now;
  }
}

}  // namespace mbgate::gateway

// SPDX-License-Identifier: Apache-2.0
// A client's socket: what it has written and the process has not read yet, and what it gets.
#include <algorithm>
#include <utility>

#include "gateway/limits.hpp"
#include "world/client.hpp"

namespace mbgate::world {

void Client::push(std::size_t bytes) {
  const auto end = unwritten_.begin() + static_cast<std::ptrdiff_t>(bytes);
  socket_.insert(socket_.end(), unwritten_.begin(), end);
  unwritten_.erase(unwritten_.begin(), end);
  pushed_ += bytes;
  for (const Mark& mark : marks_) {
    if (mark.end > pushed_ - bytes && mark.end <= pushed_) {
      tools_.ledger.asked[mark.asked].written = tools_.schedule.now();
    }
  }
  become_ready();
}

void Client::become_ready() {
  if (!paused_ && !std::exchange(is_ready_, true)) {
    tools_.driver.client_ready(while_alive([this] {
      is_ready_ = false;
      feed();
    }));
  }
}

void Client::feed() {
  while (connected_ && !paused_ && !socket_.empty()) {
    read_some();
  }
  if (connected_ && !paused_ && half_closed_ && !std::exchange(fin_read_, true)) {
    tools_.ledger.connections[connection_].half_closed = tools_.schedule.now();
    tools_.hand_in(gateway::ClientHalfClosed{number()});
  }
}

void Client::read_some() {
  const std::size_t size = std::min(socket_.size(), gateway::kClientReadSize);
  const auto end = socket_.begin() + static_cast<std::ptrdiff_t>(size);
  const Octets piece(socket_.begin(), end);
  socket_.erase(socket_.begin(), end);
  read_ += size;
  while (!marks_.empty() && marks_.front().end <= read_) {
    const Id id = marks_.front().asked;
    marks_.pop_front();
    tools_.ledger.asked[id].given = tools_.schedule.now();
    tools_.given(id);
    if (const Duration give_up = listener().give_up; give_up > Duration{0}) {
      tools_.schedule.after(give_up + 1us, while_alive([this, id] { forget(id); }));
    }
  }
  tools_.hand_in(gateway::ClientBytes{number(), piece, socket_.size()});
}

void Client::resume() {
  paused_ = false;
  tools_.driver.soon(while_alive([this] { look(); }));
}

void Client::be_read() {
  tools_.driver.client_ready(while_alive([this] { look(); }));
}

void Client::look() {
  if (!paused_ && !fin_read_ && socket_.empty()) {
    tools_.hand_in(gateway::ClientBytes{number(), {}, 0});
  }
  feed();
}

void Client::take(Bytes adu) {
  const std::uint16_t transaction = word_at(adu, 0);
  const auto found = open_.find(transaction);
  const bool is_sound =
      adu.size() >= 9 && word_at(adu, 2) == 0 && word_at(adu, 4) == adu.size() - 6;
  if (found == open_.end() || !is_sound ||
      adu[6] != tools_.ledger.asked[found->second].intent.unit) {
    tools_.report.violation("nobodys_answer",
                            "client " + std::to_string(connection_) + " got " + hex(adu));
  } else {
    const Id id = found->second;
    open_.erase(found);
    Asked& asked = tools_.ledger.asked[id];
    ++asked.answers;
    asked.answered = tools_.schedule.now();
    asked.answer.assign(adu.begin() + 7, adu.end());
    tools_.answered(id);
    if (listener().one_at_a_time) {
      forget_before(id);
    }
  }
  ++unconfirmed_;
  if (!stalled_) {
    tools_.driver.soon(while_alive([this] { confirm(); }));
  }
}

void Client::forget(Id id) {
  Asked& asked = tools_.ledger.asked[id];
  if (open_.erase(asked.transaction) > 0) {
    tools_.report.fault("not_answered");
    asked.given_up = true;
    asked.dropped = asked.sent.empty();
  }
}

// A request that was answered has replaced those before it.
void Client::forget_before(Id id) {
  const auto may_be_replaced = [this](Id it) {
    const Kind kind = tools_.ledger.asked[it].intent.kind;
    return kind == Kind::read || kind == Kind::write;  // stops may also be broadcasts
  };
  std::vector<Id> replaced;
  for (const auto& [transaction, other] : open_) {
    if (other < id && may_be_replaced(other)) {
      replaced.push_back(other);
    }
  }
  std::ranges::for_each(replaced, [this](Id it) { forget(it); });
}

void Client::confirm() {
  if (!stalled_ && unconfirmed_ > 0) {
    --unconfirmed_;
    tools_.hand_in(gateway::ClientSent{number()});
  }
}

void Client::end_stall() {
  if (std::exchange(stalled_, false)) {
    tools_.driver.client_ready(while_alive([this] {
      while (connected_ && !stalled_ && unconfirmed_ > 0) {
        confirm();
      }
    }));
  }
}

}  // namespace mbgate::world

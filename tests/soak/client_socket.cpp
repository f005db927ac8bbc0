// SPDX-License-Identifier: Apache-2.0
// A client's socket: what it has written and the process has not read yet, and what it gets.
#include <algorithm>
#include <utility>

#include "gateway/limits.hpp"
#include "soak/client.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

void Client::push(std::size_t bytes) {
  socket_.insert(socket_.end(), unwritten_.begin(),
                 unwritten_.begin() + static_cast<std::ptrdiff_t>(bytes));
  unwritten_.erase(unwritten_.begin(), unwritten_.begin() + static_cast<std::ptrdiff_t>(bytes));
  become_ready();
}

void Client::become_ready() {
  if (paused_ || std::exchange(is_ready_, true)) {
    return;
  }
  tools_.driver.client_ready([this, life = life_] {
    if (life == life_ && connected_) {
      is_ready_ = false;
      feed();
    }
  });
}

// The gateway reads as long as it likes to.
void Client::feed() {
  while (connected_ && !paused_ && !socket_.empty()) {
    read_some();
  }
  if (connected_ && !paused_ && socket_.empty()) {
    tools_.oracle.seen_empty(number_, looked_);
  }
  if (connected_ && !paused_ && half_closed_ && !fin_read_ && socket_.empty()) {
    fin_read_ = true;
    tools_.oracle.half_closed(number_);
    tools_.harness.handle(gateway::ClientHalfClosed{number_}, tools_.schedule.now());
    tools_.drain();
  }
}

void Client::read_some() {
  const std::size_t size = std::min(socket_.size(), gateway::kClientReadSize);
  const std::vector<std::uint8_t> piece(socket_.begin(),
                                        socket_.begin() + static_cast<std::ptrdiff_t>(size));
  socket_.erase(socket_.begin(), socket_.begin() + static_cast<std::ptrdiff_t>(size));
  active_ = tools_.schedule.now();
  if (hangs_since_ && *hangs_since_ == Instant::max()) {
    hangs_since_ = active_;
  }
  read_ += size;
  for (Mark& mark : marks_) {
    if (mark.begin >= read_) {
      break;
    }
    if (!std::exchange(mark.has_begun, true)) {
      tools_.oracle.begun(mark.id);
    }
  }
  while (!marks_.empty() && marks_.front().end <= read_) {
    tools_.oracle.delivered(number_, marks_.front().id);
    marks_.pop_front();
  }
  looked_ = tools_.schedule.now();
  tools_.harness.handle(gateway::ClientBytes{number_, piece, socket_.size()}, looked_);
  tools_.drain();
}

void Client::resume() {
  paused_ = false;
  tools_.driver.soon([this, life = life_] {
    if (life == life_) {
      look_at_socket();
    }
  });
}

void Client::be_read() {
  tools_.driver.client_ready([this, life = life_] {
    if (life == life_ && !fin_read_) {
      look_at_socket();
    }
  });
}

void Client::look_at_socket() {
  if (!connected_ || paused_) {
    return;
  }
  if (socket_.empty()) {
    looked_ = tools_.schedule.now();
    tools_.harness.handle(gateway::ClientBytes{number_, {}, 0}, looked_);
    tools_.drain();
  }
  feed();
}

void Client::take(Bytes adu) {
  tools_.oracle.answered(number_, adu);
  ++unconfirmed_;
  if (!stalled_) {
    tools_.driver.soon([this, life = life_] {
      if (life == life_ && connected_ && !stalled_) {
        confirm();
      }
    });
  }
}

void Client::confirm() {
  if (unconfirmed_ == 0) {
    return;
  }
  --unconfirmed_;
  active_ = tools_.schedule.now();
  tools_.oracle.answer_sent(number_);
  tools_.harness.handle(gateway::ClientSent{number_}, tools_.schedule.now());
  tools_.drain();
}

}  // namespace mbgate::soak

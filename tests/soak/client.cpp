// SPDX-License-Identifier: Apache-2.0
#include "soak/client.hpp"

#include <algorithm>

#include "gateway/limits.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr Duration kLongestCut = 5ms;  // from one part of a request to the next

routing::ClientAddress address_of(unsigned host) {
  routing::ClientAddress::Octets octets{};
  octets[10] = octets[11] = 0xFF;
  octets[12] = 10;
  octets[15] = static_cast<std::uint8_t>(host + 1);
  return routing::ClientAddress(octets);
}

}  // namespace

void Client::begin() {
  tools_.schedule.after(tools_.random.duration(0ms, 200ms), [this] {
    connect();
    plan_next();
  });
}

void Client::connect() {
  if (connected_) {
    return;
  }
  const auto listener = tools_.listener(manners_.listener);
  if (!listener) {
    reconnect_later();
    return;
  }
  number_ = tools_.new_number();
  ++life_;
  connected_ = true;
  paused_ = stalled_ = half_closed_ = fin_read_ = false;
  unconfirmed_ = 0;
  made_ = read_ = 0;
  unwritten_.clear();
  socket_.clear();
  marks_.clear();
  tools_.oracle.connect(number_, manners_.listener, manners_.host);
  tools_.gateway.handle_client_connected(number_, {*listener, address_of(manners_.host), 0},
                                         tools_.schedule.now());
  tools_.drain();
  if (connected_ && !is_welcome()) {
    tools_.oracle.violation("let_in", "a client that is not allowed");
  }
}

void Client::plan_next() {
  tools_.schedule.after(tools_.random.duration(100us, manners_.pause), [this, life = life_] {
    if (life == life_ && asking_) {
      act();
    }
  });
}

void Client::act() {
  Random& random = tools_.random;
  if (!connected_) {
    return;
  }
  if (random.chance(manners_.vanishes)) {
    vanish();
    return;
  }
  if (random.chance(manners_.half_closes)) {
    half_close();
    return;
  }
  if (!stalled_ && random.chance(manners_.stalls)) {
    tools_.report.fault("stall");
    stalled_ = true;
    tools_.schedule.after(random.duration(1ms, 2s), [this, life = life_] {
      if (life == life_) {
        end_stall();
      }
    });
  }
  ask_some();
  if (connected_) {
    plan_next();
  }
}

void Client::ask_some() {
  Random& random = tools_.random;
  for (unsigned count = random.between(1U, manners_.burst); count > 0; --count) {
    if (tools_.oracle.open_of(number_) >= manners_.outstanding) {
      break;
    }
    if (random.chance(manners_.foreign)) {
      put_foreign();
    }
    write(tools_.asking.make(manners_));
    if (!connected_) {
      return;
    }
  }
}

std::uint64_t Client::write(Asked asked) {
  while (tools_.oracle.is_open(number_, ++transactions_)) {
  }
  asked.transaction = transactions_;
  asked.host = manners_.host;
  // Behind the rest of a request that was cut it is written a little later.
  asked.written = tools_.schedule.now() + (unwritten_.empty() ? Duration{0} : kLongestCut);
  const PduBytes pdu = asked.pdu;
  const std::uint8_t unit = asked.unit;
  const std::uint64_t id = tools_.oracle.ask(number_, std::move(asked));
  const auto length = static_cast<std::uint16_t>(pdu.size() + 1);
  unwritten_.insert(unwritten_.end(), {static_cast<std::uint8_t>(transactions_ >> 8U),
                                       static_cast<std::uint8_t>(transactions_ & 0xFFU), 0, 0,
                                       static_cast<std::uint8_t>(length >> 8U),
                                       static_cast<std::uint8_t>(length & 0xFFU), unit});
  unwritten_.insert(unwritten_.end(), pdu.begin(), pdu.end());
  made_ += pdu.size() + 7;
  marks_.push_back({made_, id});
  if (unwritten_.size() == pdu.size() + 7 && tools_.random.chance(manners_.splits)) {
    tools_.report.fault("split");
    push(1 + tools_.random.below(unwritten_.size()));
    tools_.schedule.after(tools_.random.duration(10us, kLongestCut), [this, life = life_] {
      if (life == life_ && connected_) {
        push(unwritten_.size());
      }
    });
  } else if (unwritten_.size() == pdu.size() + 7) {
    push(unwritten_.size());
  }
  return id;
}

// Another protocol's ADU with a sane length: the gateway must skip exactly this.
void Client::put_foreign() {
  tools_.report.fault("foreign_adu");
  const bool alone = unwritten_.empty();
  unwritten_.insert(unwritten_.end(), {1, 2, 0, 7, 0, 4, 9, 3, 9, 9});
  made_ += 10;
  if (alone) {
    push(unwritten_.size());
  }
}

void Client::push(std::size_t bytes) {
  socket_.insert(socket_.end(), unwritten_.begin(),
                 unwritten_.begin() + static_cast<std::ptrdiff_t>(bytes));
  unwritten_.erase(unwritten_.begin(), unwritten_.begin() + static_cast<std::ptrdiff_t>(bytes));
  feed();
}

// The gateway reads as long as it likes to.
void Client::feed() {
  while (connected_ && !paused_ && !socket_.empty()) {
    const std::size_t size = std::min(socket_.size(), gateway::kClientReadSize);
    const std::vector<std::uint8_t> piece(socket_.begin(),
                                          socket_.begin() + static_cast<std::ptrdiff_t>(size));
    socket_.erase(socket_.begin(), socket_.begin() + static_cast<std::ptrdiff_t>(size));
    read_ += size;
    while (!marks_.empty() && marks_.front().end <= read_) {
      tools_.oracle.delivered(number_, marks_.front().id);
      marks_.pop_front();
    }
    tools_.gateway.handle_client_bytes(number_, piece, tools_.schedule.now(), socket_.size());
    tools_.drain();
  }
  if (connected_ && !paused_ && socket_.empty()) {
    tools_.oracle.paused(number_, false);
  }
  if (connected_ && !paused_ && half_closed_ && !fin_read_ && socket_.empty()) {
    fin_read_ = true;
    tools_.oracle.half_closed(number_);
    tools_.gateway.handle_client_half_closed(number_, tools_.schedule.now());
    tools_.drain();
  }
}

void Client::resume() {
  paused_ = false;
  tools_.schedule.after(0us, [this, life = life_] {
    if (life != life_ || !connected_ || paused_) {
      return;
    }
    if (socket_.empty()) {
      tools_.gateway.handle_client_bytes(number_, {}, tools_.schedule.now(), 0);
      tools_.drain();
    }
    feed();
  });
}

void Client::take(Bytes adu) {
  tools_.oracle.answered(number_, adu);
  ++unconfirmed_;
  if (!stalled_) {
    tools_.schedule.after(0us, [this, life = life_] {
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
  tools_.oracle.answer_sent(number_);
  tools_.gateway.handle_client_sent(number_, tools_.schedule.now());
  tools_.drain();
}

void Client::end_stall() {
  if (!stalled_) {
    return;
  }
  stalled_ = false;
  while (connected_ && unconfirmed_ > 0) {
    confirm();
  }
}

void Client::vanish() {
  tools_.report.fault("vanish");
  connected_ = false;
  tools_.oracle.gone(number_);
  tools_.gateway.handle_client_disconnected(number_, tools_.schedule.now());
  tools_.drain();
  reconnect_later();
}

void Client::half_close() {
  tools_.report.fault("half_close");
  push(unwritten_.size());
  if (!connected_) {
    return;
  }
  half_closed_ = true;
  if (paused_) {
    tools_.oracle.half_closed(number_);
    tools_.gateway.handle_client_half_closed(number_, tools_.schedule.now());
    tools_.drain();
  } else {
    feed();
  }
}

void Client::closed_by_gateway() {
  if (!half_closed_ && is_welcome()) {
    tools_.oracle.violation("closed", "the gateway closed client " +
                                          std::to_string(static_cast<std::uint64_t>(number_)));
  }
  connected_ = false;
  tools_.oracle.closed(number_);
  reconnect_later();
}

bool Client::is_welcome() const {
  return tools_.listener(manners_.listener) &&
         tools_.is_welcome(manners_.listener, address_of(manners_.host));
}

void Client::give_up() {
  connected_ = false;
  tools_.oracle.gone(number_);
  reconnect_later();
}

void Client::reconnect_later() {
  ++life_;
  if (!asking_) {
    return;
  }
  tools_.schedule.after(tools_.random.duration(100us, 300ms), [this, life = life_] {
    if (life == life_ && asking_) {
      connect();
      plan_next();
    }
  });
}

}  // namespace mbgate::soak

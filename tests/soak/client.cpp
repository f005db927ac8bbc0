// SPDX-License-Identifier: Apache-2.0
#include "soak/client.hpp"

#include <algorithm>
#include <utility>

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
    tools_.driver.client_ready([this] {
      connect();
      plan_next();
    });
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
  vanished_ = is_ready_ = paused_ = stalled_ = half_closed_ = fin_read_ = false;
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
  if (!connected_ || vanished_) {
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
  if (!manners_.never_asks) {
    ask_some();
  }
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
  marks_.push_back({made_ - pdu.size() - 7, made_, id});
  if (unwritten_.size() == pdu.size() + 7 && tools_.random.chance(manners_.splits)) {
    tools_.report.fault("split");
    push(1 + tools_.random.below(unwritten_.size()));
    tools_.schedule.after(tools_.random.duration(10us, kLongestCut), [this, life = life_] {
      if (life == life_ && connected_ && !vanished_) {
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

void Client::end_stall() {
  if (!std::exchange(stalled_, false)) {
    return;
  }
  tools_.driver.client_ready([this, life = life_] {
    while (life == life_ && connected_ && !stalled_ && unconfirmed_ > 0) {
      confirm();
    }
  });
}

void Client::vanish() {
  tools_.report.fault("vanish");
  vanished_ = true;
  tools_.driver.client_ready([this, life = life_] {
    if (life == life_ && connected_) {
      be_gone();
    }
  });
}

void Client::be_gone() {
  connected_ = false;
  tools_.oracle.gone(number_);
  tools_.gateway.handle_client_disconnected(number_, tools_.schedule.now());
  tools_.drain();
  reconnect_later();
}

void Client::half_close() {
  tools_.report.fault("half_close");
  push(unwritten_.size());
  half_closed_ = true;
  tools_.driver.client_ready([this, life = life_] {
    if (life != life_ || !connected_) {
      return;
    }
    if (paused_) {
      tools_.oracle.half_closed(number_);
      tools_.gateway.handle_client_half_closed(number_, tools_.schedule.now());
      tools_.drain();
    } else {
      feed();
    }
  });
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
    tools_.driver.client_ready([this, life] {
      if (life == life_ && asking_) {
        connect();
        plan_next();
      }
    });
  });
}

}  // namespace mbgate::soak

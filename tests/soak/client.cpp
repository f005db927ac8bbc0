// SPDX-License-Identifier: Apache-2.0
#include "soak/client.hpp"

#include <algorithm>
#include <utility>

#include "gateway/limits.hpp"
#include "soak/certificates.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr Duration kRest = 60s;
constexpr Duration kLongestCut = 5ms;  // from one part of a request to the next

}  // namespace

void Client::begin() {
  become_straddler();
  const Duration latest = manners_.waits_at_start ? 5ms : 200ms;
  tools_.schedule.after(tools_.random.duration(0ms, latest), [this] {
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
  is_silent_ = framing_lost_ = false;
  hangs_since_.reset();
  active_ = tools_.schedule.now();
  unconfirmed_ = 0;
  made_ = read_ = 0;
  unwritten_.clear();
  socket_.clear();
  marks_.clear();
  const routing::ClientRole role = read_in_certificate(manners_.role, manners_.host);
  tools_.oracle.connect(number_, manners_.listener, manners_.host,
                        role.kind != routing::ClientRole::Kind::none);
  write_before_the_start();
  is_connecting_ = true;
  const auto lets_in =
      tools_.oracle.client_rates().lets_in(manners_.listener, manners_.host, tools_.schedule.now());
  may_be_refused_ = lets_in != true;
  tools_.full = lets_in == false ? Crowded{} : crowd();
  tools_.harness.handle(
      gateway::ClientConnected{number_,
                               {*listener, address_of(manners_.host), socket_.size(), role}},
      tools_.schedule.now());
  tools_.drain();
  tools_.full = {};
  is_connecting_ = may_be_refused_ = false;
  if (connected_) {
    tools_.oracle.client_rates().let_in(manners_.listener, manners_.host, tools_.schedule.now());
  }
  if (connected_ && lets_in == false) {
    tools_.oracle.violation("let_in", "a client that connects too often");
  }
  if (connected_ && (!is_welcome() || tools_.is_stopping)) {
    tools_.oracle.violation("let_in", "a client that is not allowed");
  }
  if (connected_ && crowd().listener != kNoListener) {
    tools_.oracle.violation("let_in", "a client too many");
  }
}

void Client::plan_next() {
  Duration pause = tools_.random.duration(manners_.least_pause, manners_.pause);
  if (const Duration step = manners_.in_step; step > Duration{0}) {
    pause += step - (tools_.schedule.now().time_since_epoch() + pause) % step;
  }
  pause += tools_.plan.calm.left(tools_.schedule.now());
  tools_.schedule.after(pause, [this, life = life_] {
    if (life == life_ && asking_) {
      act();
    }
  });
}

void Client::act() {
  Random& random = tools_.random;
  if (!connected_ || vanished_ || is_silent_) {
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
  if (!half_closed_ && random.chance(manners_.hangs)) {
    hang();
    return;
  }
  if (!half_closed_ && random.chance(manners_.loses_framing)) {
    lose_framing();
    return;
  }
  if (random.chance(manners_.rests)) {
    is_silent_ = true;
    const Duration limit = tools_.settings.listeners[manners_.listener].idle_timeout;
    if (limit > Duration{0}) {
      tools_.report.fault("rest");
    } else {  // nobody closes it, and a plant in which all rest for ever shows nothing
      tools_.schedule.after(kRest, [this, life = life_] {
        if (life == life_ && connected_) {
          is_silent_ = false;
          plan_next();
        }
      });
    }
    be_closed_after(limit, "idle_timeout");
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
    be_patient();
  }
}

std::uint64_t Client::write(Asked asked) {
  while (tools_.oracle.is_open(number_, ++transactions_)) {
  }
  asked.transaction = transactions_;
  asked.host = manners_.host;
  asked.role = manners_.role;
  // Behind the rest of a request that was cut it is written a little later.
  const bool is_begun = unwritten_.empty() || keeps_tails();
  asked.written = tools_.schedule.now() + (is_begun ? Duration{0} : kLongestCut);
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
  if (keeps_tails()) {
    keep_tail(pdu.size() + 7);
  } else if (unwritten_.size() == pdu.size() + 7 && tools_.random.chance(manners_.splits)) {
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
  tools_.harness.handle(gateway::ClientDisconnected{number_}, tools_.schedule.now());
  tools_.drain();
  reconnect_later();
}

void Client::leave() {
  asking_ = false;
  if (connected_) {
    be_gone();
  }
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
      tools_.harness.handle(gateway::ClientHalfClosed{number_}, tools_.schedule.now());
      tools_.drain();
    } else {
      feed();
    }
  });
}

void Client::closed_by_gateway() {
  const bool is_excused = may_be_closed();
  tools_.report.framing_lost += framing_lost_ ? 1U : 0U;
  if (!half_closed_ && is_welcome() && !is_excused) {
    tools_.oracle.violation("closed", "the gateway closed client " +
                                          std::to_string(static_cast<std::uint64_t>(number_)));
  }
  connected_ = false;
  // Who was never let in may have written something all the same.
  is_excused || !is_welcome() ? tools_.oracle.gone(number_, kClosed)
                              : tools_.oracle.closed(number_);
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

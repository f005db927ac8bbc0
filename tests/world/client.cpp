// SPDX-License-Identifier: Apache-2.0
#include "world/client.hpp"

#include <algorithm>
#include <utility>

namespace mbgate::world {

std::function<void()> Client::while_alive(std::function<void()> what) {
  return [this, life = life_, what = std::move(what)] {
    if (life == life_ && connected_) {
      what();
    }
  };
}

void Client::begin() { come_after(tools_.random.duration(0ms, 200ms)); }

void Client::come_after(Duration delay) {
  tools_.schedule.after(delay, [this, life = life_] {
    tools_.driver.client_ready([this, life] {
      if (life == life_ && asks_) {
        connect();
        plan_next();
      }
    });
  });
}

void Client::connect() {
  ++life_;
  connected_ = true;
  leaving_ = is_ready_ = paused_ = stalled_ = half_closed_ = fin_read_ = false;
  unwritten_.clear();
  socket_.clear();
  marks_.clear();
  open_.clear();
  made_ = pushed_ = read_ = 0;
  unconfirmed_ = 0;
  connection_ = static_cast<Id>(tools_.ledger.connections.size());
  Connection connection;
  connection.listener = manners_.listener;
  connection.host = manners_.host;
  connection.process = tools_.ledger.process;
  connection.opened = tools_.schedule.now();
  tools_.ledger.connections.push_back(connection);
  const gateway::ListenerId listener{static_cast<std::uint32_t>(manners_.listener)};
  tools_.hand_in(gateway::ClientConnected{number(), {listener, address_of(manners_.host)}});
}

void Client::plan_next() {
  tools_.schedule.after(tools_.random.duration(100us, manners_.pause), while_alive([this] {
                          if (asks_ && !leaving_) {
                            act();
                          }
                        }));
}

void Client::act() {
  Random& random = tools_.random;
  if (random.chance(manners_.vanishes)) {
    vanish();
    return;
  }
  if (!half_closed_ && random.chance(manners_.half_closes)) {
    half_close();
    return;
  }
  if (half_closed_) {
    return;
  }
  if (!stalled_ && random.chance(manners_.stalls)) {
    tools_.report.fault("client_stall");
    stalled_ = true;
    tools_.schedule.after(random.duration(1ms, 2s), while_alive([this] { end_stall(); }));
  }
  ask_some();
  if (connected_) {
    plan_next();
  }
}

void Client::ask_some() {
  for (unsigned count = tools_.random.between(1U, manners_.burst); count > 0; --count) {
    if (is_waiting_enough() || !connected_) {
      return;
    }
    if (unwritten_.empty() && tools_.random.chance(manners_.foreign)) {
      tools_.report.fault("foreign_adu");
      constexpr std::array<std::uint8_t, 10> kForeign{1, 2, 0, 7, 0, 4, 9, 3, 9, 9};
      unwritten_.insert(unwritten_.end(), kForeign.begin(), kForeign.end());
      made_ += kForeign.size();
      push(unwritten_.size());
    }
    const Id id = write(tools_.asking.make(manners_));
    be_patient(id);
  }
}

// What nobody will answer is not waited for.
bool Client::is_waiting_enough() const {
  const auto is_due = [this](const auto& it) {
    return tools_.ledger.asked[it.second].intent.answer_due;
  };
  return open_.size() >= manners_.outstanding &&
         std::ranges::count_if(open_, is_due) >= std::ptrdiff_t{manners_.outstanding};
}

Id Client::write(Intent intent) {
  while (open_.contains(++transactions_)) {
  }
  const auto id = static_cast<Id>(tools_.ledger.asked.size());
  const Octets adu = tcp_adu(transactions_, intent.unit, intent.pdu);
  Asked asked;
  asked.connection = connection_;
  asked.transaction = transactions_;
  asked.intent = std::move(intent);
  asked.written = tools_.schedule.now();
  tools_.ledger.asked.push_back(std::move(asked));
  open_[transactions_] = id;
  ++tools_.report.requests;
  tools_.asked(id);
  unwritten_.insert(unwritten_.end(), adu.begin(), adu.end());
  made_ += adu.size();
  marks_.push_back({made_, id});
  if (unwritten_.size() > adu.size()) {
    return id;  // behind one that is written in two parts
  }
  if (tools_.random.chance(manners_.splits)) {
    tools_.report.fault("split");
    push(tools_.random.between<std::size_t>(1, unwritten_.size() - 1));
    tools_.schedule.after(tools_.random.duration(10us, 5ms),
                          while_alive([this] { push(unwritten_.size()); }));
  } else {
    push(unwritten_.size());
  }
  return id;
}

void Client::be_patient(Id id) {
  if (manners_.patience > Duration{0}) {
    tools_.schedule.after(manners_.patience, while_alive([this, id] { lose_patience(id); }));
  }
}

// It asks again on the same connection, or goes.
void Client::lose_patience(Id id) {
  const Asked& asked = tools_.ledger.asked[id];
  if (asked.answers > 0 || leaving_ || half_closed_ || !asks_) {
    return;
  }
  tools_.report.fault("client_gave_up");
  const bool means_the_same = tools_.ledger.reloaded < asked.written;
  if (manners_.repeats && asked.intent.kind == Kind::read && means_the_same) {
    be_patient(write(asked.intent));
  } else {
    vanish();
  }
}

void Client::vanish() {
  tools_.report.fault("client_vanished");
  leaving_ = true;
  tools_.driver.client_ready(while_alive([this] {
    be_gone();
    tools_.hand_in(gateway::ClientDisconnected{number()});
  }));
}

void Client::half_close() {
  tools_.report.fault("half_close");
  push(unwritten_.size());
  half_closed_ = true;
  tools_.driver.client_ready(while_alive([this] {
    if (paused_) {
      tools_.ledger.connections[connection_].half_closed = tools_.schedule.now();
      tools_.hand_in(gateway::ClientHalfClosed{number()});
    } else {
      feed();
    }
  }));
}

void Client::leave() {
  asks_ = false;
  if (connected_) {
    be_gone();
    tools_.hand_in(gateway::ClientDisconnected{number()});
  }
}

void Client::be_cut_off() {
  if (connected_) {
    be_gone();
  }
}

void Client::be_gone() {
  connected_ = false;
  tools_.ledger.connections[connection_].gone = tools_.schedule.now();
  for (const auto& [transaction, id] : open_) {
    tools_.ledger.asked[id].dropped = true;
  }
  tools_.gone(connection_);
  open_.clear();
  ++life_;
  if (asks_) {
    come_after(tools_.random.duration(1ms, 300ms));
  }
}

}  // namespace mbgate::world

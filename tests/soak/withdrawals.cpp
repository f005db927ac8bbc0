// SPDX-License-Identifier: Apache-2.0
#include "soak/withdrawals.hpp"

#include <algorithm>

#include "soak/oracle.hpp"

namespace mbgate::soak {
namespace {

constexpr std::uint8_t kDenied = 0x01;
constexpr std::uint8_t kNotNow = 0x06;
constexpr std::uint8_t kNoPath = 0x0A;

// It came at this instant, and the gateway has perhaps not taken it yet, but the stop.
bool may_come_behind(const Asked& write, Instant stopped) {
  return write.ahead && write.written >= stopped;
}

// The gateway perhaps has no room for it yet among those that it takes ahead.
bool may_come_later(const Asked& stop) {
  return stop.is_stop() && stop.perhaps_later && !stop.surely_on_wire && !stop.client_gone;
}

bool goes_out(const Asked& broadcast, std::size_t bus, std::uint8_t form) {
  return std::ranges::any_of(broadcast.pieces, [&](const Piece& piece) {
    return piece.bus == bus && piece.address == form;
  });
}

}  // namespace

void Withdrawals::take_back_for(const Asked& stop) const {
  // Whether a broadcast that is older than a reload stops anything still, nobody outside can tell;
  // nor when one is taken that had to wait.
  const bool is_sure = (!stop.stops_all || !oracle_.is_outdated(stop)) && !may_come_later(stop);
  const bool takes_back = is_sure && !oracle_.lets_writes_go(stop);
  note_stop(stop);
  for (const Piece& piece : stop.pieces) {
    if (Flight* last = oracle_.flight(oracle_.books_[piece.bus].last_flight)) {
      last->meets_stop = true;
    }
    if (takes_back) {
      std::ranges::for_each(stopped_by(stop, piece),
                            [this](const Lane* lane) { take_back_writes(*lane); });
      take_back_broadcasts(stop, piece.bus);
    }
  }
  if (takes_back) {
    take_back_read_ahead(stop);
  }
}

std::vector<Lane*> Withdrawals::stopped_by(const Asked& stop, const Piece& piece) const {
  std::vector<Lane*> found;
  auto& lanes = oracle_.books_[piece.bus].lanes;
  for (std::size_t address = 0; address < lanes.size(); ++address) {
    if (stop.stops_all ? stops_at(stop, piece.bus, address) : address == piece.address) {
      found.push_back(&lanes.at(address));
    }
  }
  return found;
}

void Withdrawals::note_stop(const Asked& stop) const {
  const Instant now = oracle_.schedule_.now();
  for (const Piece& piece : stop.pieces) {
    oracle_.books_[piece.bus].last_stop = now;
    for (Lane* lane : stopped_by(stop, piece)) {
      lane->last_stop = now;
    }
  }
}

void Withdrawals::note_taken(const Asked& stop) const {
  if (may_come_later(stop)) {
    note_stop(stop);
  }
}

// A stop also forbids writes that were read ahead when it came. It may be taken itself a little
// later, where another one that was read ahead has got the place of its connection that was free,
// and much later for want of room. Of its own connection it takes back what lies in front of it.
bool Withdrawals::may_be_stopped(const Asked& write) const {
  const Instant since = write.earliest - oracle_.lateness();
  const auto is_stopped = [&](const Piece& it) {
    const Book& book = oracle_.books_[it.bus];
    return (write.kind == Kind::broadcast ? book.last_stop : book.lanes[it.address].last_stop) >=
           since;
  };
  const auto may_be_now = [&](const auto& entry) {
    const Asked& stop = *entry.second;
    return may_come_later(stop) && !oracle_.lets_writes_go(stop) &&
           (stop.client != write.client || write.id < stop.id) && is_for(stop, write);
  };
  return write.changes() && !write.is_stop() &&
         (std::ranges::any_of(write.pieces, is_stopped) ||
          std::ranges::any_of(oracle_.open_, may_be_now));
}

void Withdrawals::take_back_writes(const Lane& lane) const {
  for (Asked* asked : lane.open) {
    if (asked->kind == Kind::write && !asked->doomed &&
        !may_come_behind(*asked, oracle_.schedule_.now())) {
      asked->doomed = oracle_.schedule_.now();
    }
  }
}

// Is the device at the address one that a stop for all is for?
bool Withdrawals::stops_at(const Asked& stop, std::size_t bus, std::size_t address) const {
  if (!stop.for_some) {
    return true;
  }
  const auto device = oracle_.books_[bus].lanes.at(address).device;
  return device && oracle_.plan_.peculiar[*device].stops && goes_out(stop, bus, form_of(*device));
}

std::uint8_t Withdrawals::form_of(std::size_t device) const {
  const auto& broadcast = oracle_.devices_[device].settings().profile.broadcast;
  return broadcast.form == drive::BroadcastForm::autonics ? kAutonicsAddress : std::uint8_t{0};
}

// Does a device that the stop is for hear broadcasts of this form?
bool Withdrawals::reaches(const Asked& stop, std::size_t bus, std::uint8_t form) const {
  if (!stop.stops_all) {
    return form_of(*stop.door->device) == form;
  }
  const auto& lanes = oracle_.books_[bus].lanes;
  const auto is_meant = [&](const Lane& lane) {
    return lane.device && oracle_.plan_.peculiar[*lane.device].stops &&
           form_of(*lane.device) == form;
  };
  return goes_out(stop, bus, form) && (!stop.for_some || std::ranges::any_of(lanes, is_meant));
}

// They are writes to every device of the bus; on other buses they go on.
void Withdrawals::take_back_broadcasts(const Asked& stop, std::size_t bus) const {
  for (Asked* asked : oracle_.broadcasts_on(bus)) {
    for (Piece& piece : asked->pieces) {
      const bool stopped = asked->kind == Kind::broadcast && !asked->stops_all &&
                           piece.bus == bus && reaches(stop, bus, piece.address);
      if (stopped && !piece.doomed && !may_come_behind(*asked, oracle_.schedule_.now())) {
        piece.doomed = oracle_.schedule_.now();
      }
    }
  }
}

bool Withdrawals::is_for(const Asked& stop, const Asked& write) const {
  return std::ranges::any_of(write.pieces, [&](const Piece& piece) {
    return std::ranges::any_of(stop.pieces, [&](const Piece& target) {
      return piece.bus == target.bus &&
             (write.kind == Kind::broadcast ? reaches(stop, piece.bus, piece.address)
              : stop.stops_all              ? stops_at(stop, piece.bus, piece.address)
                                            : piece.address == target.address);
    });
  });
}

// What came before it and lies behind a full pipeline. Of its own client that is what lies in front
// of it, if it was taken out of what was read ahead.
void Withdrawals::take_back_read_ahead(const Asked& stop) const {
  for (const auto& entry : oracle_.open_) {
    Asked& asked = *entry.second;
    const bool is_its_own = asked.client == stop.client;
    const bool is_earlier = is_its_own ? asked.id < stop.id : has_come_before(asked, stop.accepted);
    if (!asked.is_accepted && !asked.refused && !asked.doomed && asked.changes() &&
        !asked.is_stop() && is_earlier && is_for(stop, asked)) {
      asked.doomed = stop.accepted;
      oracle_.report_.fault("stopped_in_read_ahead");
    }
  }
}

// By other settings it lets none go first any more. What its host's rate holds up the gateway has
// perhaps not accepted yet: that it lets go.
void Withdrawals::take_back_for_waiting(const Asked& stop) const {
  if (oracle_.lets_writes_go(stop)) {
    return;
  }
  const Piece& piece = stop.pieces.front();
  const Instant now = oracle_.schedule_.now();
  for (Asked* asked : oracle_.books_[piece.bus].lanes[piece.address].open) {
    if (asked->kind == Kind::write && asked->sequence < stop.sequence && !asked->doomed &&
        !ClientRates::may_hold(*asked, oracle_.lateness(), now)) {
      asked->doomed = now;
    }
  }
}

void Withdrawals::give_back(const Asked& stop) const {
  const auto give_back = [&](std::optional<Instant>& doomed) {
    if (doomed == stop.accepted) {
      doomed.reset();
    }
  };
  for (const auto& entry : oracle_.open_) {
    give_back(entry.second->doomed);
    std::ranges::for_each(entry.second->pieces, give_back, &Piece::doomed);
  }
}

void Withdrawals::let_pass(const Session& session, const Asked& stop) const {
  if (!stop.is_stop() || !oracle_.lets_writes_go(stop)) {
    return;
  }
  for (const auto& [transaction, id] : session.by_transaction) {
    Asked& asked = *oracle_.open_.at(id);
    asked.passes_hold = asked.passes_hold || id < stop.id;
  }
}

std::vector<Asked*> Withdrawals::held_by(const std::deque<std::uint64_t>& backlog,
                                         const Asked& stop) const {
  std::vector<Asked*> writes;
  const Piece& target = stop.pieces.front();
  for (const std::uint64_t id : backlog) {
    Asked& other = *oracle_.open_.at(id);
    const bool goes_first = oracle_.lets_writes_go(stop) && id < stop.id && other.changes() &&
                            !other.is_stop() && !other.refused;
    if (goes_first && std::ranges::any_of(other.pieces, [&](const Piece& piece) {
          return piece.bus == target.bus &&
                 (piece.address == target.address || other.kind == Kind::broadcast);
        })) {
      writes.push_back(&other);
    }
  }
  return writes;
}

void Withdrawals::note_passed(const Asked& stop) const {
  const auto session = oracle_.sessions_.find(stop.client);
  if (!stop.perhaps_held || session == oracle_.sessions_.end()) {
    return;
  }
  for (Asked* write : held_by(session->second.backlog, stop)) {
    write->refused = kNotNow;
    oracle_.report_.fault("passed_by_stop");
  }
}

// What came before its unit came to mean something else is carried out neither there nor here.
void Withdrawals::refuse_outdated(Asked& asked, Instant came) const {
  if (asked.is_accepted || asked.door == nullptr || !asked.door->device ||
      oracle_.meanings_.change_of(asked.door->listener, asked.unit).surely <= came) {
    return;
  }
  asked.refused = asked.refused.value_or(kNotNow);
  asked.stops_all = false;  // it is none any more
  asked.kind = asked.kind == Kind::stop ? Kind::write : asked.kind;
  oracle_.report_.fault("outdated");
}

// Where a broadcast leads has changed with any device of its buses.
bool Withdrawals::is_older_broadcast(const Asked& asked) const {
  return asked.door != nullptr && !asked.door->device && asked.earliest < oracle_.reloaded_;
}

bool Withdrawals::may_come_before(const Asked& refused, std::uint8_t code) const {
  const bool is_outdated = oracle_.is_outdated(refused);
  // Rules come and go with their devices, and may permit what cannot be carried out anyway.
  const bool has_other_rules = refused.earliest < oracle_.reloaded_ &&
                               std::ranges::any_of(oracle_.plan_.rules, [](const SpokenRule& rule) {
                                 return !rule.devices.empty();
                               });
  switch (code) {
    case kDenied:
    case kNoPath:
      // It came, or may have come, before its unit led elsewhere. By now it may lead nowhere, or
      // its client may only read there.
      return is_outdated || has_other_rules;
    case kNotNow: break;
    default: return has_other_rules && refused.refused == kDenied;
  }
  const bool is_stopped =
      refused.unlisted && (oracle_.stopping_.has_value() || may_be_stopped(refused));
  return refused.dropped || is_stopped || is_older_broadcast(refused) || is_outdated;
}

void Withdrawals::refuse_outdated() const {
  const Instant now = oracle_.schedule_.now();
  for (const auto& entry : oracle_.open_) {
    Asked& asked = *entry.second;
    const bool has_changed =
        asked.door != nullptr &&
        oracle_.meanings_.change_of(asked.door->listener, asked.unit).surely == now;
    if (has_changed && has_come_before(asked, now)) {
      refuse_outdated(asked, asked.written);
    }
  }
}

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
#include "world/server.hpp"

#include <algorithm>

namespace mbgate::world {
namespace {
constexpr std::uint64_t kServersChance = 0x53455256ULL;
}

Server::Server(std::size_t bus, Surroundings& around) : AnyWire(bus, around, kServersChance) {}

void Server::open() {
  is_open_ = true;
  is_mute_ = false;
  last_byte_ = around_.schedule.now();
  watch_idle();
}

void Server::close() {
  is_open_ = false;
  ++epoch_;
}

void Server::hang_up(const char* kind) {
  if (is_open_) {
    around_.report.fault(kind);
    around_.hang_up(bus_);
  }
}

void Server::watch_idle() {
  if (plan_.idle_close == Duration{0} || is_calm_) {
    return;
  }
  const Instant until = last_byte_ + plan_.idle_close;
  if (around_.schedule.now() >= until) {
    hang_up("idle_close");
    return;
  }
  around_.schedule.at(until, [this, epoch = epoch_] {
    if (epoch == epoch_) {
      watch_idle();
    }
  });
}

// What is on its way when the connection ends comes all the same: the drive does it.
void Server::transmit(Id sent, Octets /*frame*/) {
  last_byte_ = around_.schedule.now();
  if (!is_mute_) {
    around_.schedule.after(random_.duration(50us, 1ms), [this, sent] { heard(sent); });
  }
}

void Server::heard(Id id) {
  const Sent& sent = around_.ledger.sent[id];
  for (const Station& station : around_.plan.stations) {
    if (!sent.readable || station.bus != bus_ ||
        (!station.every_unit && station.address != sent.address)) {
      continue;
    }
    Drive& drive = around_.drives[station.drives.front()];
    const Instant now = around_.schedule.now();
    if (!drive.has_supply(now)) {
      constexpr unsigned kTells = 500;  // permille: a gateway tells that nobody answers
      if (happens(kTells, "server_tells")) {
        const auto code = random_.one_of<std::uint8_t>({0x0A, 0x0B});
        around_.ledger.sent[id].exceptions |= 1U << code;
        say(id, {low(sent.pdu[0] | 0x80U), code}, true, false);
      }
      return;
    }
    if (happens(drive.habits.deaf, "deaf")) {
      return;
    }
    const Duration service = is_calm_ ? Duration{0} : drive.habits.service;
    drive.free() =
        std::max(drive.free(), now) + random_.duration(service * 9 / 10, service * 11 / 10);
    around_.schedule.at(drive.free(), [this, &drive, id] { respond(drive, id); });
  }
}

void Server::respond(Drive& drive, Id id) {
  const Instant now = around_.schedule.now();
  Sent& sent = around_.ledger.sent[id];
  Octets pdu = sent.pdu;
  std::optional<Octets> answer;
  if (sent.is_stop ? happens(drive.habits.refuses_stops, "stop_refused")
                   : happens(drive.habits.exceptions, "exception")) {
    const std::uint8_t code = random_.one_of<std::uint8_t>({4, 5, 6, 7});
    answer = Octets{low(pdu[0] | 0x80U), code};
  } else {
    answer = drive.carry_out(around_.ledger, id, std::move(pdu), now);
  }
  if (!answer || happens(drive.habits.never, "never")) {
    return;
  }
  if ((*answer)[0] >= 0x80) {
    around_.ledger.sent[id].exceptions |= 1U << (*answer)[1];
  }
  const drive::DeviceTiming& timing = around_.plan.timing_of(around_.plan.stations[*sent.station]);
  Duration wait = random_.duration(100us, std::max<Duration>(drive.habits.quick, 200us));
  if (happens(drive.habits.late, "late")) {
    wait += random_.duration(timing.response_timeout, 3 * timing.response_timeout);
  }
  const bool fits = (*answer)[0] >= 0x40 || !happens(drive.habits.misfits, "misfit");
  if (!fits) {
    answer->push_back(0x55);
  }
  const auto say_after = [&](Duration delay, bool is_second) {
    around_.schedule.after(delay, [this, epoch = epoch_, id, pdu = *answer, fits, is_second] {
      if (epoch == epoch_) {
        say(id, pdu, fits, is_second);
      }
    });
  };
  say_after(wait, false);
  if (happens(drive.habits.second, "second_answer")) {
    say_after(wait + random_.duration(drive.habits.second_from, drive.habits.second_to), true);
  }
}

void Server::say(Id id, const Octets& pdu, bool fits, bool is_second) {
  const Sent& sent = around_.ledger.sent[id];
  const bool is_of_before = sent.opening != around_.ledger.lines[bus_].openings;
  if (is_mute_ || !is_open_ || is_of_before) {  // it goes to the connection that has asked
    return;
  }
  const std::uint16_t identifier = plan_.keeps_identifiers ? sent.identifier : 0;
  auto unit = sent.address;
  if (happens(plan_.other_unit, "other_unit")) {
    unit ^= 0xFFU;
    fits = fits && !around_.plan.bus(bus_).check_unit;
  }
  if (happens(plan_.stray, "stray")) {
    deliver(tcp_adu(static_cast<std::uint16_t>(sent.identifier + 0x4000U), unit, pdu), {});
  }
  Came came;
  came.answers = id;
  came.is_second = is_second;
  came.fits = fits;
  Octets adu = tcp_adu(identifier, unit, pdu);
  if (happens(plan_.other_identifier, "other_identifier")) {
    adu = tcp_adu(static_cast<std::uint16_t>(sent.identifier ^ 0x1234U), unit, pdu);
    came.fits = false;
  } else if (happens(plan_.half, "half")) {
    adu.resize(random_.between<std::size_t>(1, adu.size() - 1));
    is_mute_ = true;
    if (!is_second) {  // for that nobody waits
      around_.ledger.lines[bus_].halved = id;
      around_.ledger.lines[bus_].halved_at = around_.schedule.now();
    }
    came.answers = kNone;
  } else if (happens(plan_.wrong_length, "wrong_length")) {
    adu[5] = random_.one_of<std::uint8_t>({71, 254, low(adu[5] + 1U)});
    came.fits = false;
    is_mute_ = random_.chance(300);
  }
  const std::uint64_t epoch = epoch_;
  const std::size_t first =
      random_.chance(100) ? random_.between<std::size_t>(1, adu.size()) : adu.size();
  if (first < adu.size()) {
    deliver(Octets(adu.begin(), adu.begin() + static_cast<std::ptrdiff_t>(first)), {});
    adu.erase(adu.begin(), adu.begin() + static_cast<std::ptrdiff_t>(first));
  }
  if (epoch == epoch_) {
    deliver(adu, came);
  }
  if (epoch == epoch_ && happens(plan_.closes_after, "closed_after_answer")) {
    hang_up("closes_after");
  }
}

void Server::deliver(const Octets& bytes, Came came) {
  came.at = came.said = last_byte_ = around_.schedule.now();
  came.bytes = bytes.size();
  around_.deliver(bus_, bytes, came);
}

void Server::begin_trouble() {
  if (plan_.hangs_every > Duration{0}) {
    hang();
  }
  for (const Station& station : around_.plan.stations) {
    const std::size_t drive = station.drives.front();
    if (station.bus == bus_ && around_.drives[drive].habits.sleeps_every > Duration{0}) {
      lose_supply(drive);
    }
  }
}

void Server::hang() {
  around_.schedule.after(random_.duration(plan_.hangs_every / 4, 2 * plan_.hangs_every), [this] {
    if (!is_calm_) {
      around_.report.fault("hang");
      is_mute_ = true;
      hang();
    }
  });
}

void Server::lose_supply(std::size_t number) {
  const Duration every = around_.drives[number].habits.sleeps_every;
  around_.schedule.after(random_.duration(every / 4, 2 * every), [this, number] {
    Drive& drive = around_.drives[number];
    if (!is_calm_) {
      around_.report.fault("without_supply");
      drive.lose_supply(around_.schedule.now() + random_.duration(10ms, drive.habits.sleeps_for));
      lose_supply(number);
    }
  });
}

void Server::calm_down() {
  is_calm_ = true;
  if (is_mute_) {
    hang_up("mute_connection_ended");
  }
}

}  // namespace mbgate::world

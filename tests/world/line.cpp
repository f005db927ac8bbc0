// SPDX-License-Identifier: Apache-2.0
// How bytes travel over a line, and what becomes of them.
#include "world/line.hpp"

#include <algorithm>

namespace mbgate::world {
namespace {

constexpr std::uint64_t kLinesChance = 0x4C494E45ULL;
constexpr Duration kTick = 16ms;
constexpr Duration kKept = 20ms;
constexpr Duration kLongestStall = 9s;
constexpr std::uint8_t kStrangers = 60;  // addresses from there on are other clients' drives

}  // namespace

Line::Line(std::size_t bus, Surroundings& around)
    : AnyWire(bus, around, kLinesChance),
      times_(around.plan.bus(bus).line),
      ascii_(around.plan.bus(bus).line.framing == bus::Framing::ascii),
      phase_(random_.duration(Duration{0}, kTick)) {}

Octets Line::encode(std::uint8_t address, Bytes pdu) const {
  return ascii_ ? ascii_frame(address, pdu) : rtu_frame(address, pdu);
}

void Line::open() {
  is_open_ = true;
  constexpr unsigned kGoesOn = 200;  // permille
  is_deaf_ = is_deaf_ && random_.chance(kGoesOn);
  for (auto& [bytes, came] : std::exchange(held_, {})) {
    around_.report.fault("held_by_server");
    came.was_held = true;
    hand_in(bytes, came);
  }
}

void Line::close() {
  is_open_ = false;
  ++epoch_;
  kept_.clear();
  sending_ = kNone;
  own_end_ = std::min(own_end_, around_.schedule.now());
  arrived_ = Instant::min();
}

std::size_t Line::unsent() const {
  std::size_t bytes = 0;
  for (const Frame& frame : kept_) {
    bytes += frame.bytes.size();
  }
  const Instant now = around_.schedule.now();
  return own_end_ > now ? bytes + static_cast<std::size_t>((own_end_ - now) / times_.of(1)) : bytes;
}

void Line::transmit(Id sent, Octets frame) {
  if (stalls_) {
    around_.report.fault("kept_by_adapter");
    kept_.push_back({sent, std::move(frame)});
  } else {
    leave({sent, std::move(frame)});
  }
}

void Line::leave(const Frame& frame) {
  const Instant now = around_.schedule.now();
  const Instant begin = std::max(now, own_end_);
  own_end_ = begin + times_.of(frame.bytes.size());
  sending_ = frame.sent;
  own_damaged_ = false;
  for (auto& [number, talk] : talks_) {
    if (talk.begin <= now && talk.end > now) {
      own_damaged_ = true;
      around_.report.fault("collision");
      garble(talk);
    }
  }
  if (plan_.echoes) {
    say(frame.bytes, begin, frame.bytes.size(), {}, {});
    echo_ = numbers_;
    if (own_damaged_) {
      garble(talks_.at(echo_));
    }
  }
  around_.schedule.at(own_end_, [this, epoch = epoch_, sent = frame.sent] {
    if (epoch == epoch_ && !own_damaged_ && !(is_deaf_ && swallows_)) {
      Sent& it = around_.ledger.sent[sent];
      it.left = around_.schedule.now();
      if (around_.ledger.lines[bus_].heard < it.begin) {
        it.heard = it.left;
      }
      heard(sent);
    }
  });
}

// A chunk holds what a few milliseconds bring.
void Line::say(Octets bytes, Instant begin, std::size_t good, const Came& came, Pause pause) {
  const std::uint64_t number = ++numbers_;
  const Duration step = random_.duration(500us, 4ms);
  const auto most = std::max<std::size_t>(1, static_cast<std::size_t>(step / times_.of(1)));
  std::vector<std::pair<Instant, std::size_t>> chunks;
  for (std::size_t at = 0; at < bytes.size();) {
    std::size_t next = std::min(bytes.size(), at + most);
    if (pause.at > at && pause.at < next) {
      next = pause.at;
    }
    if (good > at && good < next) {
      next = good;
    }
    const Duration paused = pause.at > 0 && at >= pause.at ? pause.length : Duration{0};
    chunks.emplace_back(begin + times_.of(next) + paused, next);
    at = next;
  }
  const Instant end = chunks.back().first;
  talks_.emplace(number, Talk{std::move(bytes), begin, end, good, came});
  around_.schedule.at(begin, [this, number] { begin_talk(number); });
  for (const auto& [at, until] : chunks) {
    around_.schedule.at(at, [this, number, heard = until] { hear(number, heard); });
  }
}

void Line::begin_talk(std::uint64_t number) {
  const Instant now = around_.schedule.now();
  const auto found = talks_.find(number);
  if (found == talks_.end() || number == echo_) {
    return;
  }
  bool collides = own_end_ > now;
  own_damaged_ = own_damaged_ || collides;
  for (auto& [other, talk] : talks_) {
    if (other != number && talk.begin <= now && talk.end > now) {
      collides = true;
      garble(talk);
    }
  }
  if (collides) {
    around_.report.fault("collision");
    garble(found->second);
  }
}

// From now on nobody can read it.
void Line::garble(Talk& talk) {
  talk.damaged = true;
  for (std::size_t at = talk.heard; at < talk.bytes.size(); ++at) {
    talk.bytes[at] =
        low(ascii_ ? talk.bytes[at] | 0x80U : talk.bytes[at] ^ random_.between(1U, 255U));
    if (!ascii_ && ends_in_its_crc(Bytes(talk.bytes).first(at + 1))) {
      talk.bytes[at] ^= 1U;
    }
  }
}

Instant Line::arrival(Instant now) {
  Instant at = now;
  if (plan_.adapter == AdapterKind::ticking) {
    at = now + (kTick - (now - phase_).time_since_epoch() % kTick);
  } else if (plan_.adapter == AdapterKind::late) {
    at = now + random_.duration(0us, kKept);
  }
  return arrived_ = std::max(arrived_, at);
}

void Line::hear(std::uint64_t number, std::size_t until) {
  const auto found = talks_.find(number);
  if (found == talks_.end()) {
    return;
  }
  Talk& talk = found->second;
  const Octets bytes(talk.bytes.begin() + static_cast<std::ptrdiff_t>(talk.heard),
                     talk.bytes.begin() + static_cast<std::ptrdiff_t>(until));
  Came came = talk.came;
  const bool ends = talk.heard < talk.good && until >= talk.good;
  if (!ends || talk.damaged) {
    came.answers = kNone;
  }
  talk.heard = until;
  if (until == talk.bytes.size()) {
    talks_.erase(found);
  }
  came.said = around_.schedule.now();
  came.bytes = bytes.size();
  if (is_open_ && !is_deaf_) {
    hand_in(bytes, came);
  } else if (!is_open_ && !is_calm_ && around_.plan.bus(bus_).line.remote) {
    held_.emplace_back(bytes, came);
  }
}

void Line::hand_in(const Octets& bytes, Came came) {
  came.at = arrival(around_.schedule.now());
  around_.schedule.at(came.at, [this, epoch = epoch_, bytes, came] {
    if (epoch == epoch_) {
      around_.deliver(bus_, bytes, came);
    }
  });
}

void Line::again(Duration every, void (Line::*what)()) {
  if (every > Duration{0} && !is_calm_) {
    around_.schedule.after(random_.duration(every / 4, 2 * every), [this, every, what] {
      if (!is_calm_) {
        (this->*what)();
        again(every, what);
      }
    });
  }
}

void Line::begin_trouble() {
  again(plan_.noise_every, &Line::make_noise);
  again(plan_.stranger_every, &Line::ask_as_stranger);
  again(plan_.hangs_every, &Line::hang);
  again(plan_.stalls_every, &Line::stall);
  for (const Station& station : around_.plan.stations) {
    for (const std::size_t drive : station.drives) {
      if (station.bus == bus_ && around_.drives[drive].habits.sleeps_every > Duration{0}) {
        lose_supply(drive);
      }
    }
  }
}

void Line::calm_down() {
  is_calm_ = true;
  is_deaf_ = false;
  plan_.adapter = AdapterKind::uart;
  end_stall();
}

void Line::make_noise() {
  around_.report.fault("noise");
  Octets noise(random_.between(1U, 6U));
  for (auto& byte : noise) {
    byte = random_.one_of<std::uint8_t>({0x00, 0xFF, low(random_.below(256U))});
    byte = ascii_ && (byte == ':' || byte == '\n' || byte == '\r') ? 0xFF : byte;
  }
  say(std::move(noise), around_.schedule.now(), 0, {}, {});
}

// A drive that is none of ours is asked, and answers.
void Line::ask_as_stranger() {
  const Instant now = around_.schedule.now();
  if (own_end_ > now || !talks_.empty()) {
    return;
  }
  around_.report.fault("stranger");
  const auto address = low(kStrangers + random_.below(100U));
  const Octets asked = encode(address, request(3, random_.below(100U), 2));
  const Octets answer = encode(address, Octets{3, 4, low(random_.below(256U)), 1, 2, 3});
  const Instant then =
      now + times_.of(asked.size()) + times_.silence() + random_.duration(0ms, 5ms);
  say(asked, now, 0, {}, {});
  say(answer, then, 0, {}, {});
}

void Line::hang() {
  around_.report.fault("hang");
  is_deaf_ = true;
  swallows_ = random_.chance(500);
}

void Line::stall() {
  if (!is_open_ || stalls_) {
    return;
  }
  around_.report.fault("adapter_stall");
  stalls_ = true;
  around_.schedule.after(random_.duration(50ms, kLongestStall), [this] { end_stall(); });
}

void Line::end_stall() {
  stalls_ = false;
  for (const Frame& frame : std::exchange(kept_, {})) {
    leave(frame);
  }
}

}  // namespace mbgate::world

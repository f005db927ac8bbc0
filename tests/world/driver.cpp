// SPDX-License-Identifier: Apache-2.0
#include "world/driver.hpp"

#include <algorithm>
#include <utility>

namespace mbgate::world {
namespace {

constexpr Duration kLateness = 20ms;
constexpr Duration kStall = 500ms;
constexpr std::uint64_t kWakesForAStall = 5000;
constexpr std::uint64_t kStopsChance = 0x53544F5053ULL;
constexpr std::uint64_t kWakesForAStop = 3000;
constexpr Duration kShortStop = 300ms;
constexpr Duration kLongStop = 1500ms;
constexpr Duration kBeat = 250ms;      // it notices what it has missed by missing beats,
constexpr Duration kMissable = 500ms;  // if that was longer
constexpr Duration kInterruption = 2ms;
constexpr Duration kNoticed = 1ms;  // less is not counted
constexpr Duration kWakeEarly = 100us;
constexpr std::ptrdiff_t kAtOnce = 512;  // bytes of a line

}  // namespace

DriverManners draw_driver(Random& random, std::uint64_t seed) {
  DriverManners manners;
  constexpr unsigned kSome = 200;
  manners.stops = Random(seed ^ kStopsChance).chance(kSome);
  const unsigned kind = random.between(0U, 9U);
  if (kind < 3) {
    return manners;
  }
  manners.any_order = random.chance(700);
  manners.usual = random.duration(0us, 300us);
  manners.spurious = random.one_of({0U, 0U, 50U});
  if (kind < 6) {
    manners.late = random.between(1U, 20U);
    return manners;
  }
  manners.late = random.between(50U, 400U);
  manners.slow = random.one_of({0U, 20U, 100U});
  manners.stalls = random.chance(500);
  return manners;
}

Driver::Driver(const DriverManners& manners, std::size_t buses, std::uint64_t seed,
               Schedule& schedule, Hands hands)
    : manners_(manners),
      random_(seed),
      of_stops_(seed ^ kStopsChance),
      schedule_(schedule),
      hands_(std::move(hands)),
      lines_(buses) {}

Duration Driver::lateness() {
  if (manners_.usual == Duration{0} && manners_.late == 0) {
    return Duration{0};
  }
  if (manners_.stalls && random_.below(kWakesForAStall) == 0) {
    hands_.fault("driver_stalled");
    return random_.duration(kLateness, kStall);
  }
  if (manners_.late > 0 && random_.chance(manners_.late)) {
    const Duration late = random_.duration(0us, kLateness);
    if (late > kNoticed) {
      hands_.fault("driver_late");
    }
    return late;
  }
  return random_.duration(0us, manners_.usual);
}

void Driver::ready(Ready it) {
  ready_.push_back(std::move(it));
  if (is_watching() && ready_.back().line != kNoLine) {
    wakes_ = schedule_.now();
    watch_ended_ = true;
  } else if (!wakes_ && !awake_) {
    wakes_ = schedule_.now() + lateness();
  }
}

// It is awake already, and nothing but the end of the silence keeps it.
bool Driver::is_watching() const {
  return !awake_ && !stop_ && deadline_ && deadline_->ends_silence && timer_ == deadline_->at &&
         schedule_.now() >= deadline_->at - kWakeEarly;
}

void Driver::come_back() {
  const auto stop = std::exchange(stop_, std::nullopt);
  if (!stop) {
    return;
  }
  const Duration missed = schedule_.now() - stop->since + of_stops_.duration(0ms, kBeat);
  if (missed > kMissable) {
    hands_.stalled(missed);
  }
}

void Driver::list(std::size_t bus) {
  unread_ = true;
  if (!lines_[bus].listed && lines_[bus].open) {
    lines_[bus].listed = true;
    ready({bus, false, {}});
  }
}

void Driver::line_bytes(std::size_t bus, const Bytes& bytes) {
  Bytes& waiting = lines_[bus].bytes;
  waiting.insert(waiting.end(), bytes.begin(), bytes.end());
  list(bus);
}

void Driver::line_lost(std::size_t bus) {
  lines_[bus].lost = true;
  list(bus);
}

void Driver::watch_line(std::size_t bus) {
  lines_[bus].open = true;
  if (!lines_[bus].bytes.empty() || lines_[bus].lost) {
    list(bus);
  }
}

void Driver::forget_line(std::size_t bus) {
  const bool listed = lines_[bus].listed;
  lines_[bus] = Line{};
  lines_[bus].listed = listed;
}

void Driver::read_line(std::size_t bus) {
  Line& line = lines_[bus];
  while (line.open && !line.bytes.empty()) {
    const auto end = line.bytes.begin() + std::min<std::ptrdiff_t>(std::ssize(line.bytes), kAtOnce);
    const Bytes piece(line.bytes.begin(), end);
    line.bytes.erase(line.bytes.begin(), end);
    hands_.bytes(bus, piece);
  }
  if (line.open && line.lost) {
    forget_line(bus);
    hands_.lost(bus);
  }
}

void Driver::run_soon() {
  while (!soon_.empty()) {
    const Handler handler = std::move(soon_.front());
    soon_.pop_front();
    handler();
  }
}

// A machine serves its descriptors in the order of their numbers, of their readiness, or as its
// library likes it.
void Driver::put_in_order(std::vector<Ready>& bunch) {
  if (!manners_.any_order || bunch.size() < 2) {
    return;
  }
  if (const unsigned first = random_.between(0U, 2U); first < 2) {
    std::ranges::stable_partition(bunch,
                                  [&](const Ready& it) { return it.is_client == (first == 0); });
  }
}

void Driver::judge_deadline() {
  const auto deadline = hands_.next_wake();
  const bool is_due =
      std::exchange(watch_ended_, false) || (deadline && deadline->at <= schedule_.now());
  if (!is_due && (manners_.spurious == 0 || !random_.chance(manners_.spurious))) {
    return;
  }
  if (!is_due) {
    hands_.fault("spurious_call");
  } else if (unread_) {
    hands_.fault("unread_at_deadline");
  }
  if (promises_ && std::exchange(unread_, false)) {
    for (std::size_t bus = 0; bus < lines_.size(); ++bus) {
      read_line(bus);
    }
  }
  hands_.deadline();
  run_soon();
}

void Driver::wake() {
  awake_ = true;
  wakes_.reset();
  come_back();
  const bool is_judged_first = !promises_ || (manners_.any_order && random_.chance(300));
  if (is_judged_first) {
    judge_deadline();
  }
  std::vector<Ready> bunch = std::exchange(ready_, {});
  put_in_order(bunch);
  for (const Ready& it : bunch) {
    if (it.line == kNoLine) {
      it.handler();
    } else {
      lines_[it.line].listed = false;
      read_line(it.line);
    }
    run_soon();
    if (manners_.slow > 0 && random_.chance(manners_.slow)) {
      hands_.interrupt(random_.duration(10us, kInterruption));
    }
  }
  judge_deadline();
  awake_ = false;
  if (!ready_.empty()) {
    wakes_ = schedule_.now() + lateness();
  }
  set_timer();
  if (manners_.stops && of_stops_.below(kWakesForAStop) == 0) {
    hands_.fault("driver_stopped");
    stop_ = {schedule_.now(), schedule_.now() + of_stops_.duration(kShortStop, kLongStop)};
  }
}

void Driver::set_timer() {
  const auto next = hands_.next_wake();
  const bool is_set = next && deadline_ && next->at == deadline_->at &&
                      next->ends_silence == deadline_->ends_silence;
  if (is_set && *timer_ > schedule_.now()) {
    return;
  }
  deadline_ = next;
  timer_.reset();
  if (next) {
    const Duration early = next->ends_silence ? kWakeEarly : Duration{0};
    timer_ = std::max({next->at, schedule_.now(), next->at - early + lateness()});
  }
}

}  // namespace mbgate::world

// SPDX-License-Identifier: Apache-2.0
#include "soak/offline_rules.hpp"

#include <algorithm>

#include "soak/heard_answers.hpp"
#include "soak/oracle.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;
namespace {

constexpr int kPercent = 100;

}  // namespace

void OfflineRules::check(Flight& flight, const Flight* before) const {
  if (oracle_.is_tcp(flight.bus) || flight.is_broadcast) {
    return;
  }
  const Lane& lane = oracle_.books_[flight.bus].lanes[flight.address];
  flight.may_be_probe = may_be_probe(flight, lane);
  if (flight.is_stop) {
    check_room(flight, before);
    check_stop(flight, before);
    check_cut(flight, before);
  } else if (oracle_.is_surely_offline(lane)) {
    check_probe(flight, lane);
  }
}

// Its device may be offline, or may have been when this was accepted: a late answer brings a device
// back while its probe waits, and that stays one.
bool OfflineRules::may_be_probe(const Flight& flight, const Lane& lane) const {
  return oracle_.is_past_offline(flight.bus, lane) ||
         std::ranges::any_of(flight.asked, [&](std::uint64_t id) {
           const auto entry = oracle_.open_.find(id);
           return entry != oracle_.open_.end() && lane.last_offline >= entry->second->accepted;
         });
}

void OfflineRules::check_ended(std::size_t bus, const Lane& lane, const Flight& last) const {
  for (const Asked* asked : lane.open) {
    const bool is_judged = (asked->kind == Kind::read || asked->kind == Kind::write) &&
                           !asked->is_stop() && asked->accepted < last.begin && !asked->ordered &&
                           !asked->ahead && asked->replies && !asked->client_gone;
    if (is_judged && asked->pieces.front().bus == bus) {
      oracle_.violation("waits_for_offline", oracle_.name(*asked));
      return;
    }
  }
}

void OfflineRules::check_probe(Flight& probe, const Lane& lane) const {
  probe.is_probe = true;
  const Duration interval = oracle_.devices_[*lane.device].settings().timing.probe_interval;
  if (probe.begin < lane.asked_last + interval) {
    oracle_.violation("probe_early", oracle_.name(probe));
  }
  check_share(probe);
  oracle_.books_[probe.bus].last_probe = probe.number;
}

// Where somebody asks a device that is there, the probes that nobody answers share little of the
// time. A probe that was answered asked a device that was not there before.
void OfflineRules::check_share(const Flight& probe) const {
  const Book& book = oracle_.books_[probe.bus];
  const auto& settings = oracle_.bus_settings(probe.bus);
  const Flight* before = oracle_.flight(book.last_probe);
  if (before == nullptr || before->begin < std::max(oracle_.reloaded_, book.opened) ||
      before->came > 0 || !before->expects_answer || before->beside_stop || before->meets_stop ||
      !book.lanes[before->address].device) {
    return;
  }
  bool somebody_asks = somebody_waits(probe);
  for (std::uint64_t number = before->number + 1; number < probe.number; ++number) {
    const Flight* other = oracle_.flight(number);
    somebody_asks |= other != nullptr && other->bus == probe.bus && other->is_answered &&
                     !other->is_stop && !other->may_be_probe &&
                     probe.begin < other->begin + settings.timing.probe_interval;
  }
  const auto& device = oracle_.devices_[*book.lanes[before->address].device].settings();
  const Duration took = before->end - before->begin + spec::probe_timeout_of(device.timing);
  const Duration early = before->begin + took * kPercent / settings.probe_share - probe.begin;
  if (somebody_asks && early > Duration{0}) {
    oracle_.violation("probe_share",
                      oracle_.name(probe) + " " + std::to_string(early / 1us) + " us too early");
  }
}

// A request to a device that is there has waited since before.
bool OfflineRules::somebody_waits(const Flight& probe) const {
  const Book& book = oracle_.books_[probe.bus];
  return std::ranges::any_of(book.lanes, [&](const Lane& lane) {
    return lane.device && !oracle_.is_past_offline(probe.bus, lane) &&
           std::ranges::any_of(lane.open, [&](const Asked* asked) {
             return (asked->kind == Kind::read || asked->kind == Kind::write) &&
                    asked->pieces.size() == 1 && !asked->ordered && !asked->ahead &&
                    !asked->dropped && !asked->doomed && asked->replies && !asked->client_gone &&
                    asked->accepted > lane.last_offline && asked->accepted < probe.begin;
           });
  });
}

// Another offline device is probed first: somebody asks for it, or has, not long ago.
bool OfflineRules::may_go_first(std::size_t bus, const Lane& other, const Lane& lane) const {
  if (&other == &lane || !oracle_.is_past_offline(bus, other)) {
    return false;
  }
  const Duration interval = other.device
                                ? oracle_.devices_[*other.device].settings().timing.probe_interval
                                : oracle_.bus_settings(bus).timing.probe_interval;
  return !other.open.empty() || oracle_.schedule_.now() <= other.wanted_at + interval;
}

// Until then at the latest the probes that were transmitted keep back another one.
Instant OfflineRules::share_ends(std::size_t bus) const {
  const gateway::BusSettings& settings = oracle_.bus_settings(bus);
  Instant ends = Instant::min();
  for (const auto& kept : oracle_.flights_) {
    const Flight& flight = *kept;
    if (flight.bus == bus && !flight.is_stop && !flight.is_answered) {
      const Duration rest = flight.came > 0 ? oracle_.rest_of_answer(flight) : Duration{0};
      const Duration took =
          flight.due - flight.begin + settings.turnaround + rest + 2 * oracle_.lateness();
      ends = std::max(ends, flight.begin + took * kPercent / settings.probe_share);
    }
  }
  return ends;
}

// For so long nobody has asked for a device that may have been there that probes need not share.
bool OfflineRules::is_idle(std::size_t bus) const {
  const Book& book = oracle_.books_[bus];
  const gateway::BusSettings& settings = oracle_.bus_settings(bus);
  Instant busy = book.others_gone;
  for (const auto& flight : oracle_.flights_) {
    if (flight->bus == bus && !flight->is_probe) {
      busy = std::max(busy, flight->due + settings.turnaround + oracle_.rest_of_answer(*flight));
    }
  }
  const auto is_waited_for = [](const Lane& lane) {
    return !std::ranges::all_of(lane.open, &Asked::for_dead);
  };
  return std::ranges::none_of(book.lanes, is_waited_for) &&
         oracle_.schedule_.now() > busy + settings.timing.probe_interval + 2 * oracle_.lateness();
}

// Untried, though a probe was due, and no other one has taken so much that this one must wait.
void OfflineRules::judge_refused(const Asked& asked) const {
  if (asked.flights > 0 || !asked.door->device || asked.ordered || asked.pieces.size() != 1) {
    return;
  }
  const std::size_t bus = asked.pieces.front().bus;
  Book& book = oracle_.books_[bus];
  Lane& lane = book.lanes[asked.pieces.front().address];
  const Instant now = oracle_.schedule_.now();
  const auto& timing = oracle_.devices_[*asked.door->device].settings().timing;
  lane.wanted_at = now;
  if (asked.accepted != now || asked.ahead || oracle_.is_tcp(bus) || !book.open ||
      book.last_down >= now || oracle_.stopping_ || !oracle_.is_surely_offline(lane) ||
      lane.open.size() > 1 || now <= lane.held_until + timing.probe_interval) {
    return;
  }
  const bool is_first = std::ranges::none_of(
      book.lanes, [&](const Lane& other) { return may_go_first(bus, other, lane); });
  if (is_first && (now > share_ends(bus) || is_idle(bus))) {
    oracle_.violation("probe_withheld", oracle_.name(asked));
  }
}

// The device left its last try unanswered: a probe waits for its own timeout, and nothing is tried
// once more that must not be.
void OfflineRules::judge_wait(const Asked& asked) const {
  const Flight* last = oracle_.flight(asked.last_flight);
  const bool is_last =
      last != nullptr && (last->is_probe || (asked.kind == Kind::write && !asked.retry_writes));
  if (!is_last || oracle_.is_tcp(last->bus) || asked.ordered || asked.pieces.size() != 1 ||
      oracle_.stopping_ || oracle_.reloaded_ >= last->begin || last->is_cut_off ||
      asked.is_stop() || last->asked.size() != 1 || oracle_.bus_settings(last->bus).merge) {
    return;
  }
  const auto until = last->came > 0 ? HeardAnswers(oracle_).stuck_until(*last) : last->due;
  if (!until || (last->came > 0 && oracle_.books_[last->bus].last_flight != last->number)) {
    return;
  }
  const Duration late = oracle_.schedule_.now() - *until;
  if (late > 2 * oracle_.lateness()) {
    oracle_.violation("told_late", oracle_.name(asked) + " " + std::to_string(late / 1us) +
                                       " us after its timeout");
  }
}

void OfflineRules::judge_shown(const Asked& asked, const PduBytes& pdu) const {
  const unsigned first = spec::word_at(asked.pdu, 1);
  const bool is_health = first >= kDevicesAt && (first - kDevicesAt) % kDeviceSize == 0 &&
                         spec::word_at(asked.pdu, 3) == kShownOfHealth;
  if (!is_health || pdu.size() != 2U + 2U * kShownOfHealth || asked.ordered ||
      oracle_.reloaded_ != Instant::min()) {
    return;
  }
  const std::size_t bus = spec::word_at(pdu, 2) - 1U;
  const unsigned address = spec::word_at(pdu, 4);
  if (bus >= oracle_.books_.size() || address >= oracle_.books_[bus].lanes.size()) {
    oracle_.violation("shown_wrongly", oracle_.name(asked) + ": no such device");
    return;
  }
  const Lane& lane = oracle_.books_[bus].lanes[address];
  const unsigned state = spec::word_at(pdu, 6);
  const unsigned in_row = spec::word_at(pdu, 8);
  const bool is_wrong = state == kShownOffline ? !oracle_.is_past_offline(bus, lane)
                                               : oracle_.is_surely_offline(lane);
  if (is_wrong || in_row < lane.silent || in_row > lane.unanswered) {
    oracle_.violation("shown_wrongly", oracle_.name(asked) + ": state " + std::to_string(state) +
                                           ", unanswered " + std::to_string(in_row));
  }
}

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
// Stops to devices that are silent: they are tried once, cut nothing, and leave the others the
// line.
#include <algorithm>

#include "soak/offline_rules.hpp"
#include "soak/oracle.hpp"

namespace mbgate::soak {

// All that waits on the bus are stops to this device, none of which was tried before it was given
// up.
bool OfflineRules::are_all_given_up(std::size_t bus, const Lane& lane) const {
  const Book& book = oracle_.books_[bus];
  return lane.given_up_after && std::ranges::all_of(book.open_stops, [&](const Asked* stop) {
           return !stop->stops_all && !stop->failsafe && !stop->ordered && !stop->ahead &&
                  &book.lanes[stop->pieces.front().address] == &lane &&
                  stop->sequence > *lane.given_up_after;
         });
}

// To a device that was given up a stop is tried once, and nothing that runs is cut for it.
void OfflineRules::check_stop(const Flight& stop, const Flight* before) const {
  const Book& book = oracle_.books_[stop.bus];
  const Lane& lane = book.lanes[stop.address];
  if (!oracle_.is_surely_offline(lane) || !lane.given_up_after) {
    return;
  }
  for (const std::uint64_t id : stop.asked) {
    const auto entry = oracle_.open_.find(id);
    if (entry != oracle_.open_.end() && stop.asked.size() == 1 &&
        entry->second->sequence > *lane.given_up_after && !entry->second->failsafe &&
        !entry->second->is_shared && entry->second->pieces.front().sent > 1) {
      oracle_.violation("dead_stop_repeated", oracle_.name(stop));
    }
  }
  if (is_cut_by(stop, before) && !before->is_stop && are_all_given_up(stop.bus, lane)) {
    oracle_.violation("dead_stop_cuts", oracle_.name(*before) + " for " + oracle_.name(stop));
  }
}

bool OfflineRules::is_cut_by(const Flight& stop, const Flight* before) const {
  const Book& book = oracle_.books_[stop.bus];
  return before != nullptr && before->expects_answer && before->came == 0 &&
         stop.begin < before->deadline && std::max(book.opened, oracle_.reloaded_) < before->begin;
}

// What runs has as much time as a stop waits, each time anew; a stop itself from its end on.
void OfflineRules::check_cut(const Flight& stop, const Flight* before) const {
  const Book& book = oracle_.books_[stop.bus];
  const Duration wait = oracle_.bus_settings(stop.bus).stop_wait;
  const bool is_early = before != nullptr && before->is_stop
                            ? before->address != stop.address && stop.begin < before->end + wait
                            : book.open_stops.size() == 1 && stop.begin < waits_from(stop) + wait;
  if (is_cut_by(stop, before) && is_early && !oracle_.stopping_) {
    oracle_.violation("stop_cuts_early", oracle_.name(*before) + " for " + oracle_.name(stop));
  }
}

// From its acceptance, or the end of its last try.
Instant OfflineRules::waits_from(const Flight& stop) const {
  Instant from = stop.stop_from.value_or(stop.begin);
  for (const std::uint64_t id : stop.asked) {
    const auto entry = oracle_.open_.find(id);
    if (entry == oracle_.open_.end()) {
      continue;
    }
    const Asked& asked = *entry->second;
    if (asked.tries.size() > 1) {
      const Flight* last = oracle_.flight(*(asked.tries.end() - 2));
      const bool may_end =
          last != nullptr && (last->came > 0 || last->beside_stop || last->meets_stop);
      from =
          last == nullptr ? Instant::min() : std::min(from, may_end ? last->end : last->deadline);
    } else {
      from = std::min(from, asked.earliest);
    }
  }
  return from;
}

// Between two stops to a device that is silent one request to another device goes, if one waits
// that nothing holds back. A stop waits for that no longer than `stop_wait` from the end of the try
// before it, whoever's that was.
void OfflineRules::check_room(const Flight& stop, const Flight* before) const {
  const Book& book = oracle_.books_[stop.bus];
  const bool follows = before != nullptr && before->is_stop && before->address == stop.address &&
                       before->expects_answer && before->came == 0 && stop.begin >= before->due &&
                       std::max(book.opened, oracle_.reloaded_) < before->begin &&
                       book.lanes[stop.address].device;
  const bool are_alone = std::ranges::all_of(book.open_stops, [&](const Asked* other) {
    return !other->stops_all && other->pieces.front().address == stop.address;
  });
  if (!follows || !are_alone || oracle_.stopping_) {
    return;
  }
  const gateway::BusSettings& settings = oracle_.bus_settings(stop.bus);
  const bool has_waited =
      stop.begin + settings.settle + oracle_.lateness() > before->due + settings.stop_wait;
  if (has_waited) {
    return;
  }
  if (const Asked* other = TurnRules(oracle_).waiting_for_room(stop, before->due)) {
    oracle_.violation("stop_gives_no_room", oracle_.name(*other) + " beside " + oracle_.name(stop));
  }
}

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
// Who goes between two tries of a stop, or of a read, that nobody answered, and while a device is
// left alone.
#include <algorithm>

#include "soak/oracle.hpp"
#include "soak/turns.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

const Asked* TurnRules::waiting_for_room(const Flight& stop, Instant since) const {
  const Book& book = oracle_.books_[stop.bus];
  for (const Lane& lane : book.lanes) {
    // A stop may let the writes before it go, and then nothing goes before these.
    const bool may_be_held = &lane == &book.lanes[stop.address];
    const bool is_clear = std::ranges::all_of(lane.open, [&](const Asked* asked) {
      return asked->is_stop() || (!asked->maybe_on_wire && asked->kind != Kind::broadcast &&
                                  !(may_be_held && asked->changes()));
    });
    if (!is_clear) {
      return nullptr;
    }
  }
  const auto others = others_that_may_go(stop);
  const auto other = std::ranges::find_if(others, [&](const Asked* asked) {
    return asked->pieces.front().address != stop.address && asked->accepted < since &&
           asked->waited_until < since;
  });
  return other == others.end() ? nullptr : *other;
}

// What is on the wire, or waits for its next try.
bool TurnRules::is_in_use(std::uint8_t address, const Flight& beside) const {
  const Book& book = oracle_.books_[beside.bus];
  return std::ranges::any_of(book.lanes[address].open,
                             [&](const Asked* asked) {
                               return asked->maybe_on_wire &&
                                      std::ranges::find(beside.asked, asked->id) ==
                                          beside.asked.end();
                             }) ||
         std::ranges::any_of(book.unheard, [&](std::uint64_t number) {
           const Flight* other = oracle_.flight(number);
           return number != beside.number && other != nullptr && other->address == address;
         });
}

// Others do not wait for a device that is left alone. What is read may share a transmission that is
// to be repeated.
void TurnRules::check_idle(const Flight& flight, Instant free, Duration lateness) const {
  const Book& book = oracle_.books_[flight.bus];
  if (flight.asked.empty() || !book.has_only_usual() || oracle_.stopping_) {
    return;
  }
  for (const Asked* other : others_that_may_go(flight, kLongestGap)) {
    const std::uint8_t address = other->pieces.front().address;
    const Instant from = std::max({free, book.lanes[address].held_until, book.use.waits_from,
                                   oracle_.reloaded_, other->accepted, other->waited_until});
    if (flight.begin - from > lateness && address != flight.address &&
        !is_in_use(address, flight)) {
      oracle_.violation("idle_beside", oracle_.name(*other) + " for " +
                                           std::to_string((flight.begin - from) / 1us) +
                                           " us, then " + oracle_.name(flight));
      return;
    }
  }
}

// Whose turns were taken between two tries of a read: stops take none. None if what was transmitted
// between them may leave something to repeat.
std::optional<std::bitset<256>> TurnRules::turns_taken(const Flight& read,
                                                       const Flight& before) const {
  std::bitset<256> taken;
  for (std::uint64_t number = before.number + 1; number < read.number; ++number) {
    const Flight* other = oracle_.flight(number);
    const bool is_here = other != nullptr && other->bus == read.bus;
    if (other == nullptr || (is_here && (!other->is_answered || other->is_broadcast))) {
      return std::nullopt;
    }
    taken[other->address] = taken[other->address] || (is_here && !other->is_stop);
  }
  return taken;
}

// Others that waited when it was not answered go first.
void TurnRules::check_repeat(const Flight& read, const Flight& before) const {
  const Book& book = oracle_.books_[read.bus];
  const bool is_next = before.number == book.last_flight;
  // Whoever was passed over for its gap is waited for.
  const bool is_alone =
      is_next || std::ranges::all_of(book.lanes, [&](const Lane& lane) {
        return std::ranges::all_of(lane.open, [&](const Asked* asked) {
          return asked->id == read.asked.front() ||
                 (!asked->maybe_on_wire && lane.device && gap_at(lane) == Duration{0});
        });
      });
  const bool is_clear = is_alone && (is_next ? book.came == 0 : book.use.is_answered) &&
                        book.has_only_usual() && !oracle_.stopping_ &&
                        before.begin > std::max(book.opened, oracle_.reloaded_);
  const auto taken = is_clear ? turns_taken(read, before) : std::nullopt;
  if (!taken) {
    return;
  }
  for (const Asked* other : others_that_may_go(read)) {
    if (other->pieces.front().address != read.address && !other->maybe_on_wire &&
        !taken->test(other->pieces.front().address) &&
        std::max(other->accepted, other->waited_until) < before.deadline) {
      oracle_.violation("repeated_first", oracle_.name(read) + " before " + oracle_.name(*other));
      return;
    }
  }
}

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
// Bounds that the settings and the drives set: how long a line is listened to, what may be merged,
// when an expired request is told so, and when a line is opened again.
#include <algorithm>

#include "soak/oracle.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

void Oracle::check_bounds(const Flight& flight) {
  if (!is_tcp(flight.bus) && !flight.is_stop && flight.begin < books_[flight.bus].listens_until) {
    violation("listened_too_short", name(flight));
  }
  check_offline(flight);
  check_merged(flight);
}

// Reads that are transmitted as one: never longer than the drive takes, never across a parameter
// group, never over registers that cannot be read. What one request asks for is its own matter.
void Oracle::check_merged(const Flight& flight) {
  const auto& device = books_[flight.bus].lanes[flight.address].device;
  const bool is_merged = std::ranges::none_of(flight.asked, [&](std::uint64_t id) {
    const auto entry = open_.find(id);
    return entry == open_.end() ||
           std::ranges::any_of(entry->second->pieces,
                               [&](const Piece& piece) { return piece.pdu == flight.pdu; });
  });
  const auto fields = is_merged ? spec::fields_of(flight.pdu) : std::nullopt;
  if (!device || !fields || !fields->reads || flight.asked.empty()) {
    return;
  }
  const drive::Profile& profile = devices_[*device].settings().profile;
  const spec::Range& range = *fields->reads;
  const unsigned end = range.first + range.count;
  const auto meets = [&](const auto& other) {
    return other.table == range.table && other.first < end &&
           range.first < unsigned{other.first} + other.count;
  };
  const auto crosses = [&](const auto& group) {
    const unsigned group_end = unsigned{group.first} + group.count;
    return meets(group) && (range.first < group.first || end > group_end);
  };
  if (range.count > profile.limits.read_from(range.table)) {
    violation("merged_too_long", name(flight));
  }
  if (std::ranges::any_of(profile.write_only, meets) ||
      std::ranges::any_of(profile.groups, crosses)) {
    violation("merged_too_far", name(flight));
  }
}

// Of what was never transmitted, or was and can be no more: as soon as the deadline is over, or the
// wait for the answer to what was transmitted before.
void Oracle::judge_expiry(const Asked& asked) {
  if (stopping_) {
    return;
  }
  if (asked.is_stop() || asked.ordered || asked.ahead || asked.client_gone || !asked.replies ||
      asked.pieces.empty() || asked.kind == Kind::own || asked.deadline == Instant::max()) {
    return;
  }
  Instant ends = std::max({asked.deadline, asked.accepted, reloaded_});
  if (const Flight* last = asked.last_flight != 0 ? flight(asked.last_flight) : nullptr) {
    const Book& book = books_[last->bus];
    const Instant heard = is_tcp(last->bus) ? last->due : std::max(last->due, book.last_handed_in);
    ends = std::max({ends, heard + rest_of_answer(*last), book.turnaround_end, book.held_until});
  } else if (asked.maybe_on_wire) {
    return;  // too long ago
  }
  const Duration late = schedule_.now() - ends;
  if (late > 2 * lateness()) {
    const Flight* last = asked.last_flight != 0 ? flight(asked.last_flight) : nullptr;
    violation(
        "expired_late",
        name(asked) + " " + std::to_string(late / 1us) + " us late, its deadline was " +
            std::to_string((schedule_.now() - asked.deadline) / 1us) + " us ago, transmitted " +
            (last == nullptr ? "never"
                             : std::to_string((schedule_.now() - last->begin) / 1us) + " us ago"));
  }
}

// A full queue takes the newest read of a client address back: none that waits in the same
// connection is newer. Reads that are shared wait with others, in the place of these.
void Oracle::judge_eviction(const Asked& asked) {
  if (stopping_) {
    return;
  }
  const Instant now = schedule_.now();
  const auto session = sessions_.find(asked.client);
  // What is refused a moment after it was taken never waited.
  const auto waits = [&](const Asked& it) {
    return it.is_read() && it.pieces.size() == 1 && it.pieces.front().counted &&
           it.accepted + lateness() < now;
  };
  if (session == sessions_.end() || !waits(asked) || asked.pieces.front().taken_back ||
      reloaded_ >= asked.accepted || now >= asked.deadline - (asked.written - asked.earliest)) {
    return;
  }
  const std::size_t bus = asked.pieces.front().bus;
  if (bus_settings(bus).coalesce || bus_settings(bus).merge) {
    return;
  }
  for (const std::uint64_t id : session->second.order) {
    const Asked& other = *open_.at(id);
    if (waits(other) && other.pieces.front().bus == bus && other.sequence > asked.sequence) {
      violation("evicted_older", name(asked) + " before " + name(other));
      return;
    }
  }
}

// The delay doubles; a line that has served for long begins anew.
void Oracle::note_loss(std::size_t bus) {
  Book& book = books_[bus];
  const auto& settings = bus_settings(bus);
  Reopening& reopening = book.reopening;
  const bool has_served = book.open && schedule_.now() >= book.opened + settings.reopen_max;
  if (has_served || reopening.delay == 0ms) {
    reopening.delay = settings.reopen_min;
  }
  reopening.at = schedule_.now() + reopening.delay;
  reopening.delay = std::min(2 * reopening.delay, settings.reopen_max);
}

void Oracle::check_reopening(std::size_t bus) {
  Reopening& reopening = books_[bus].reopening;
  const auto at = std::exchange(reopening.at, std::nullopt);
  if (at && !is_tcp(bus) && schedule_.now() < *at) {
    violation("reopened_early", bus_settings(bus).name);
  } else if (at && !is_tcp(bus) && schedule_.now() > *at + lateness()) {
    violation("reopened_late", bus_settings(bus).name);
  }
}

}  // namespace mbgate::soak

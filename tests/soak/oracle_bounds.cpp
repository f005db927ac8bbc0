// SPDX-License-Identifier: Apache-2.0
// Bounds that the settings set: how long a line is listened to, when an expired request is told so,
// and when a line is opened again.
#include <algorithm>

#include "soak/full_queue.hpp"
#include "soak/oracle.hpp"
#include "soak/shared_reads.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

// A line is listened to when it was opened, and left alone for a while when an answer did not come.
void Oracle::check_bounds(const Flight& flight, const Flight* before) {
  SharedReads(*this).check_bounds(flight);
  if (is_tcp(flight.bus) || flight.is_stop) {
    return;
  }
  const Book& book = books_[flight.bus];
  const bool was_silent = before != nullptr && before->expects_answer && !before->beside_stop &&
                          !before->meets_stop && !has_failsafe(flight.bus) && book.came == 0 &&
                          before->begin > std::max(book.opened, reloaded_);
  if (was_silent && flight.begin < before->deadline + bus_settings(flight.bus).settle) {
    violation("not_settled", name(flight));
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
  if (had_another_more(books_[bus], bus, asked, is_tcp(bus) ? bus_settings(bus).outstanding : 1,
                       lateness(), now)) {
    violation("evicted_of_another", name(asked));
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

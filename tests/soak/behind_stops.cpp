// SPDX-License-Identifier: Apache-2.0
#include "soak/behind_stops.hpp"

#include <algorithm>

#include "soak/oracle.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

// A write that was to go before a stop does not go after it, nor does a part of one.
void BehindStops::check(const Asked& asked, const Flight& flight, bool alone) const {
  Lane& lane = oracle_.books_[flight.bus].lanes[flight.address];
  if (asked.ordered || asked.ahead || !alone || !asked.door->device) {
    return;
  }
  if (asked.kind == Kind::stop && !asked.is_shared && !asked.failsafe) {
    lane.stopped_after = std::max(lane.stopped_after, asked.sequence);
  } else if (asked.kind == Kind::write && asked.sequence < lane.stopped_after) {
    oracle_.violation("write_behind_stop", oracle_.name(flight));
  }
}

// Its client was told that it is done: the writes before it are not sent any more.
void BehindStops::note_done(const Asked& asked) const {
  if (asked.kind == Kind::stop && !asked.ordered && !asked.ahead) {
    Lane& lane = oracle_.books_[asked.pieces.front().bus].lanes[asked.pieces.front().address];
    lane.stopped_after = std::max(lane.stopped_after, asked.sequence);
  }
}

// Nothing but the stop that it should have gone before has kept it from going: with the pauses
// before it that stop would not have been held up for too long.
void BehindStops::judge_not_sent(const Asked& write) const {
  const Piece& piece = write.pieces.front();
  const Book& book = oracle_.books_[piece.bus];
  const Lane& lane = book.lanes[piece.address];
  const Instant now = oracle_.schedule_.now();
  const bool is_plain = write.kind == Kind::write && write.is_accepted && write.door->device &&
                        !write.doomed && !write.dropped && !write.ordered && !write.ahead &&
                        write.earliest == write.written;
  if (!is_plain || book.open_stops.size() != 1 || book.stops.size() != 1 || !book.open ||
      oracle_.stopping_ || oracle_.reloaded_ >= book.opened || oracle_.is_tcp(piece.bus) ||
      now >= write.deadline || book.last_full >= write.accepted || lane.held_until >= now ||
      oracle_.is_past_offline(piece.bus, lane)) {
    return;
  }
  const Asked& stop = *book.stops.front();
  if (!stop.waits_from || !oracle_.lets_writes_go(stop) || !oracle_.is_surely_open(stop) ||
      stop.pieces.front().address != piece.address || stop.sequence < write.sequence) {
    return;
  }
  // Between two tries of something it may have had its turn.
  const auto& settings = oracle_.bus_settings(piece.bus);
  const bool is_clear = book.lanes[0].open.empty() && book.lanes[kAutonicsAddress].open.empty() &&
                        std::ranges::all_of(book.lanes, [](const Lane& it) {
                          return std::ranges::none_of(
                              it.open, [](const Asked* asked) { return asked->maybe_on_wire; });
                        });
  // A line that was opened just now is listened to, but not for the stop.
  const Instant could_go = std::max(*stop.waits_from, book.opened + spec::silence_of(settings));
  const Duration pause = std::max({oracle_.devices_[*lane.device].settings().timing.gap,
                                   settings.settle, book.listens_until - could_go});
  const Duration held = stop.longest_held + pause + (stop.let_go + 2) * oracle_.lateness();
  if (is_clear && held <= settings.stop_wait &&
      now < std::max(*stop.waits_from, book.busy_since) + oracle_.stop_deadline(piece.bus)) {
    oracle_.violation("not_let_go", oracle_.name(write) + " before " + oracle_.name(stop));
  }
}

// Writes that go before it, and wait for something themselves, hold a stop up for `stop_wait` in
// all. `free`: since then nothing on the line itself has held the transmission up. Where noise
// stood before an answer, that may have begun a frame of which more could come: then the wait for
// the answer was over only with the silence that ends frames.
void BehindStops::note_held(const Flight& flight, Instant free) const {
  const Book& book = oracle_.books_[flight.bus];
  if (book.open_stops.size() != 1 || book.stops.size() != 1 || oracle_.reloaded_ >= book.opened) {
    return;
  }
  Asked& stop = *book.stops.front();
  const Lane& lane = book.lanes[stop.pieces.front().address];
  if (!stop.waits_from || !oracle_.lets_writes_go(stop) || !oracle_.is_surely_open(stop) ||
      lane.may_repeat_stop(flight.begin)) {
    return;
  }
  const auto& settings = oracle_.bus_settings(flight.bus);
  const bool is_over = book.use.fitting > book.own_end;
  const Instant since =
      is_over ? std::max({book.turnaround_end, book.held_until, book.last_handed_in}) +
                    spec::silence_of(settings)
              : free;
  const Instant shown =
      is_over && book.use.is_behind_noise
          ? book.last_handed_in +
                std::max(spec::slack_of(settings), spec::WireTimes(settings.line).silence())
          : since;
  const auto held_from = [&](Instant from) {
    return std::max<Duration>(flight.begin - std::max(from, *stop.waits_from), Duration{0});
  };
  stop.held += held_from(std::max(since, shown));
  stop.longest_held += held_from(since);
  ++stop.let_go;
  if (stop.held > settings.stop_wait + (stop.let_go + 1) * oracle_.lateness()) {
    oracle_.violation("stop_held", oracle_.name(stop) + " for " + std::to_string(stop.held / 1us) +
                                       " us by " + oracle_.name(flight));
    stop.held = Duration{0};
  }
}

}  // namespace mbgate::soak

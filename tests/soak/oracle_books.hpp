// SPDX-License-Identifier: Apache-2.0
// What the oracle keeps of connections, lines and the addresses on them.
#pragma once

#include <array>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <unordered_map>

#include "soak/asked.hpp"
#include "soak/flight.hpp"

namespace mbgate::soak {

constexpr const char* kClosed = "for_closed_client";  ///< by the gateway
/// Of a gateway that is told to stop: so long what is on the wire has for its answer.
constexpr Duration kGrace = std::chrono::milliseconds(1500);
constexpr Duration kStopLife = std::chrono::seconds(900);  ///< hundreds may wait on a slow line

/// What is compared with the gateway's own counters.
struct BusCount {
  std::uint64_t transmissions = 0;
  std::uint64_t broadcasts = 0;
  std::uint64_t losses = 0;
  std::uint64_t stops = 0;
  std::uint64_t spoilt_echoes = 0;
  std::uint64_t asking = 0;   ///< transmissions that are to be answered
  std::uint64_t silent = 0;   ///< transmissions that were surely not answered
  std::uint64_t damaged = 0;  ///< those that surely were, with a bad CRC
  std::uint64_t excused = 0;  ///< others whose echo may have been taken for an answer
};

/// A connection of a client.
struct Session {
  std::size_t listener = 0;
  bool has_tls = false;  ///< what it has sent may lie elsewhere than in its socket
  Instant read_empty;    ///< nothing lay in its socket then
  bool ordered = false;  ///< as it was at the beginning
  bool half_closed = false;
  Instant ahead_until = Instant::min();  ///< places may be taken for free a little early
  std::optional<Instant> paused_since;
  std::size_t outstanding = 0;
  std::deque<std::uint64_t> backlog;  ///< delivered, not accepted
  std::deque<std::uint64_t> taken;    ///< stops that were accepted before others in front of them
  std::deque<std::uint64_t> order;    ///< accepted, not answered
  std::unordered_map<std::uint16_t, std::uint64_t> by_transaction;
  std::deque<std::uint16_t> answered;  ///< the last transactions that are done
  std::deque<std::uint16_t> silent;    ///< done without a reply; a failure may still be told
};

/// Wrong answers that physics excuses, at an address (oracle_slips.cpp).
struct Slips {
  Instant caused = Instant::min();  ///< when something was new last
  Instant until = Instant::min();   ///< they belong to one start
  unsigned wrong = 0;               ///< at that start
  unsigned starts = 0;
  std::uint64_t flight = 0;  ///< the last one
};
constexpr const char* kStrangers = "strangers";
constexpr unsigned kCleanForgets = 200;  ///< answers, after which a second one is new again

/// An address on a bus.
struct Lane {
  std::optional<std::size_t> device;
  std::vector<Asked*> open;
  std::deque<std::uint64_t> sent;  ///< the last transmissions that are to be answered
  Slips slips;
  Duration shown{0};  ///< the longest time of an answer that it has shown
  Instant shown_at = Instant::min();
  Duration second_shown{0};               ///< the same from an answer to a second one
  unsigned clean = kCleanForgets;         ///< answers since then
  Instant last_offline = Instant::min();  ///< it may have been offline then
  unsigned unanswered = 0;                ///< transmissions since the last good answer, at most
  std::vector<std::uint64_t> unheard;     ///< on a connection, what is later than that answer
  BusCount count;
  bool knows_order = false;    ///< its drive was asked for its word order
  bool stays_offline = false;  ///< it was perhaps offline when other settings came
  // Transmissions in a row that were certainly unanswered, at least:
  unsigned silent = 0;
  Instant last_write_event = Instant::min();
  Instant earlier_write_event = Instant::min();  ///< the last one of an earlier instant
  Instant last_stop = Instant::min();
  std::map<PduBytes, Instant> stops_done;  ///< when the device carried each out last
  Instant written_at = Instant::min();     ///< something that is no stop, to it or to all
  Instant uncertain_at = Instant::min();   ///< nobody can tell what a frame of then answered
  // Nothing is kept of what was read of its device:
  Instant emptied_at = Instant::min();    ///< since then, because it did not answer, or by the line
  Instant emptied_for = Instant::min();   ///< if it was read before then
  Instant boots_until = Instant::min();   ///< at the earliest: it was told what it never answers
  std::uint64_t stop_sent = 0;            ///< the last one sent to it
  std::optional<Instant> stop_sent_at{};  ///< of a broadcast too

  /// A stop like one that was acknowledged within a second lets one other go first. Whether it was
  /// acknowledged, whether a write came meanwhile, and how many others went is not asked here.
  [[nodiscard]] bool may_repeat_stop(Instant now) const {
    constexpr auto kPerhapsAcknowledged = std::chrono::seconds(3);
    return stop_sent_at && now < *stop_sent_at + kPerhapsAcknowledged;
  }
  /// Something of it was heard, or is not known any more.
  void forget_silence() { silent = 0; }
};

/// What is known for certain of when a serial line could be used.
struct LineUse {
  Instant first_read = Instant::min();  ///< of what came behind the last own transmission
  Duration pause{0};                    ///< the longest between two readings of it
  bool is_answered = false;             ///< that answer was read, and met no fault
  Instant fitting = Instant::min();     ///< it was read; a stop may have ended the wait before
};

/// When a line that could not be opened, or died, is opened again.
struct Reopening {
  std::optional<Instant> at;  ///< none: as soon as somebody asks
  Duration delay{0};          ///< of the next time; 0: the shortest
};

/// A bus.
struct Book {
  void note_size(std::size_t queue, Instant now) { last_full = present >= queue ? now : last_full; }

  /// Whether what was said last was heard to its end is not known.
  void forget_boots() {
    for (Lane& lane : lanes) {
      lane.boots_until = Instant::min();
    }
  }

  std::array<Lane, 256> lanes;
  bool open = false;
  bool starting = true;  ///< it has not been opened yet: requests wait
  bool rests = false;    ///< the same, because its server has closed the connection
  bool opening = false;
  bool is_restarted = false;           ///< it was silent for too long
  std::vector<std::uint64_t> in_vain;  ///< to a server from which nothing has come since
  Instant last_down = Instant::min();
  Instant last_full = Instant::min();  ///< no room for one more
  Instant last_stop = Instant::min();
  Instant own_end = Instant::min();
  Instant last_byte = Instant::min();
  Instant last_handed_in = Instant::min();
  Instant turnaround_end = Instant::min();
  Instant held_until = Instant::min();  ///< the same by settings that came meanwhile
  std::size_t waiting = 0;              ///< requests that are surely in its queue
  std::size_t present = 0;              ///< requests that may be, no stops
  std::vector<Asked*> stops;            ///< that wait
  std::vector<Asked*> open_stops;       ///< that wait or were sent
  std::vector<Asked*> early_stops;      ///< that wait for the line to be opened first
  std::vector<std::uint64_t> flying;    ///< on TCP buses
  std::vector<std::uint64_t> unheard;   ///< the same, as if no stop cut anything
  std::uint64_t last_flight = 0;
  std::uint64_t last_other = 0;         ///< the last one that was no stop
  Instant busy_since = Instant::min();  ///< no silence since then
  std::size_t room = 0;                 ///< more than the queue's limit may still wait from before
  Instant last_merge = Instant::min();  ///< reads accepted until then may be merged
  Duration stop_wait_before{0};
  Instant stop_wait_from = Instant::min();  ///< it is what it is
  BusCount count;
  // Of the own transmission that was last:
  std::size_t came = 0;                ///< bytes that have reached the kernel since its beginning
  std::size_t read = 0;                ///< of these the gateway has
  std::size_t before_pause = 0;        ///< of these, those before the last silence in reading them
  std::array<std::uint8_t, 4> tail{};  ///< the last of them
  PduBytes heard;                      ///< the first of them: no more than a frame, and one
  Instant read_while_sending = Instant::min();  ///< when bytes were read last before its end
  std::vector<HeardFrame> unread;               ///< good frames in the kernel
  std::vector<std::uint64_t> unread_answers;    ///< the same on a connection, to these
  std::vector<std::uint64_t> misnamed;          ///< their answers name another unit, unread
  std::optional<HeardEcho> unread_echo;
  bool unread_stranger = false;      ///< the request of another client
  bool is_strange = false;           ///< what came looks like an echo, and is none
  Instant touched = Instant::min();  ///< other times or rules were set for it
  LineUse use;
  Reopening reopening;
  // Of the line, since it was opened:
  bool echo_found = false;  ///< the gateway says that there is an echo
  Instant opened = Instant::min();
  Instant listens_until = Instant::min();  ///< after a new start of the process
  bool is_first = true;                    ///< it was not opened since then
  unsigned openings = 0;
  bool is_unused = true;  ///< nothing was transmitted
  bool echo_proven = false;
  bool echo_lost = false;   ///< one that would have proven it did not come at all
  unsigned since_echo = 0;  ///< transmissions since a whole echo came
  bool told_unproven = false;
  bool told_while_sending = false;
  bool must_tell_unproven = false;
  bool told_denied = false;
  bool must_tell_denied = false;
  unsigned requests_heard = 0;         ///< own ones and those of others
  bool denied_echo = false;            ///< one came of what was transmitted last
  bool denied_before = false;          ///< and of what was before it
  Instant denied_at = Instant::min();  ///< the last one came

  /// It is opened anew.
  void forget_line() {
    unread.clear();
    unread_answers.clear();
    misnamed.clear();
    unread_echo.reset();
    echo_proven = echo_lost = echo_found = false;
    told_unproven = told_while_sending = must_tell_unproven = false;
    told_denied = must_tell_denied = denied_echo = denied_before = false;
    requests_heard = 0;
  }
};

/// What outlives the process: its transmissions, which devices may still answer.
struct Past {
  std::deque<std::unique_ptr<Flight>> flights;
  std::uint64_t flight_count;
  std::uint64_t ids;
  std::vector<unsigned> openings;
};

/// A request that is over.
struct Done {
  std::uint64_t id;
  std::size_t bus;
  std::uint8_t address;
  PduBytes pdu;
  std::string how;
  Instant at;
};

}  // namespace mbgate::soak

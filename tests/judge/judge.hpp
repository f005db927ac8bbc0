// SPDX-License-Identifier: Apache-2.0
// The judge of a run: a short list of truths, each a function over the ledger. It asks for truth
// and never for turns: what was given to clients, and what was put on the wire, but not whose turn
// it was. Where physics leaves something uncertain, it is counted apart, and bounded.
#pragma once

#include <map>

#include "world/world.hpp"

namespace mbgate::judge {

using namespace world;  // NOLINT(google-build-using-namespace): it is about nothing else

/// What was read then may be its answer.
inline Instant oldest_of(const Asked& asked, const drive::Device* device) {
  return asked.given - (device == nullptr ? Duration{0} : device->cache);
}

class Judge : public Witness {
 public:
  explicit Judge(World& world)
      : world_(world),
        plan_(world.plan()),
        ledger_(world.ledger()),
        report_(world.report()),
        slips_(plan_.stations.size()) {}

  void asked(Id asked) override;
  void given(Id asked) override;
  void answered(Id asked) override;
  void sent(Id sent) override;
  void came(std::size_t bus) override;
  void reloaded() override;
  /// After come_to_rest(): everything was answered, and everybody is served again.
  void check_rest();
  /// After shut_down().
  void check_end();

 private:
  [[nodiscard]] bool is_overfull(Id connection, Instant at) const;
  void check_answered();
  /// Wrong answers of a device whose lateness or second answers must first be learned.
  struct Slips {
    unsigned wrong = 0;  ///< since something was new
    unsigned stale = 0;  ///< the same, of those that show what was asked for, as it was before
    unsigned right = 0;  ///< since the last wrong one
    unsigned process = 0;
    Instant last{};  ///< the frame that was wrong: it may have answered several requests
  };

  // truth_answers.cpp: what a client gets is what its drive says, or a refusal that is true.
  void check_exception(const Asked& asked);
  void note_exception(const Asked& asked, const char* kind);
  bool is_check_by_chance(std::size_t bus);
  void check_read(Id id);
  void check_write(Id id);
  [[nodiscard]] bool held(const Station& station, Table table, unsigned first,
                          std::span<const std::uint16_t> words, Span span) const;
  [[nodiscard]] bool shows(const Asked& asked) const;
  [[nodiscard]] bool shows_inputs(const Asked& asked) const;
  [[nodiscard]] bool was_done(const Asked& asked) const;
  void note_echo_shown(const Asked& asked);
  [[nodiscard]] bool is_echo_unknown(const Asked& asked, const Came& last) const;
  [[nodiscard]] bool is_later_than_ever(const Asked& asked, const Came& last) const;
  [[nodiscard]] bool is_after_hold(const Came& late) const;
  void note_wrong(const Asked& asked, const char* kind);
  void note_right(const Asked& asked);

  // truth_writes.cpp: a write is sent once, in time, for somebody, and not after its stop.
  [[nodiscard]] bool asks_order(const Sent& sent) const;
  void check_asked_for(const Sent& sent);
  void check_once(Id id);
  void check_late(Id id);
  void check_overdue(const Asked& asked);
  void check_gone(Id id);
  void check_stopped(const Sent& sent);
  void check_limits(const Sent& sent);

  // truth_failsafe.cpp: failsafe writes go when a client has gone, and only then.
  void note_asked_of(const Asked& asked);
  [[nodiscard]] Instant gone_since(unsigned host, std::size_t station) const;
  void check_failsafe(const Sent& sent);
  void check_failsafe_done();

  // truth_stops.cpp: a stop goes soon, and is repeated where its drive says "not now".
  [[nodiscard]] bool follows_silence(const Sent& stop, Id id) const;
  void check_stop_time(Id id);
  void check_refused_stop(const Asked& asked);

  // truth_bounds.cpp: what is fast enough, over a run.
  struct Share {
    unsigned got = 0;
    unsigned lost = 0;    ///< though the answer came in time
    unsigned ended = 0;   ///< waits, by a frame that did not fit
    unsigned waited = 0;  ///< for the whole timeout all the same
  };
  void note_share(const Asked& asked);
  void check_shares();

  // truth_wire.cpp: one transaction at a time, with silence; who may still answer is left alone.
  void check_silence(Id id);
  void check_waiting(Id id);
  void check_gap(Id id);
  void check_hold(Id id);
  void check_half(Id id);
  void check_heard(Id id);
  [[nodiscard]] Duration longest_wait_of(std::size_t station) const;

  void violation(const char* kind, const std::string& text) { report_.violation(kind, text); }
  [[nodiscard]] std::string name(const Asked& asked) const;
  [[nodiscard]] std::string name(const Sent& sent) const;
  [[nodiscard]] const Door& door_of(const Asked& asked) const {
    return plan_.doors[asked.intent.door];
  }
  /// As the settings in force have it.
  [[nodiscard]] Duration deadline_of(const Asked& asked) const {
    const Door& door = door_of(asked);
    const Duration limit =
        asked.intent.kind == Kind::read ? door.read_deadline : door.write_deadline;
    const Duration give_up = plan_.settings.listeners[door.listener].give_up;
    return give_up > Duration{0} ? std::min(limit, give_up) : limit;
  }
  [[nodiscard]] Instant now() const { return world_.now(); }

  World& world_;
  const Plan& plan_;
  const Ledger& ledger_;
  Report& report_;
  std::vector<Slips> slips_;
  struct ShowsEcho {
    unsigned opening = 0;
    unsigned reads = 0;  ///< that were answered since
    Instant at{};        ///< when that was enough
  };
  std::map<std::size_t, ShowsEcho> shows_echo_;  // by bus
  std::unordered_map<Id, Duration> deadlines_;
  std::unordered_map<Id, Duration> waits_;  ///< by transmission: the longest for its answer
  /// By host and station: connections that have asked it; were they answered?
  std::map<std::pair<unsigned, std::size_t>, std::map<Id, bool>> askers_;
  std::map<std::size_t, std::map<unsigned, unsigned>> wrote_;  ///< process by station and host
  bool has_broadcast_ = false;
  std::map<std::size_t, Share> shares_;      ///< by bus
  std::unordered_map<Id, Instant> misfits_;  ///< by transmission
};

}  // namespace mbgate::judge

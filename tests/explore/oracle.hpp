// SPDX-License-Identifier: Apache-2.0
// What must hold in a small world. It sees what clients ask and get, what goes over the wire and
// what comes from it, and owes the product nothing.
#pragma once

#include <string>
#include <utility>

#include "explore/ledger.hpp"

namespace mbgate::explore {

/// For so long an adapter may keep bytes, and a stop that was acknowledged counts.
inline constexpr Duration kAdapterKeeps = std::chrono::milliseconds(20);
inline constexpr Duration kStopCounts = std::chrono::seconds(1);

class Oracle {
 public:
  explicit Oracle(const Plant& plant);

  // What happens, in its order.
  /// A request lies in its socket. Returns its slot.
  std::size_t note_asked(const Ask& ask, Instant now);
  /// The gateway is given all that lies in the client's socket.
  void note_taken(std::uint8_t client, Instant now);
  void note_transmitted(const Octets& frame, Instant now);
  /// The answer to a transmission is handed in, good and whole.
  void note_heard(Flight& flight, Instant now);
  /// Bytes are handed in.
  void note_bytes(Instant now) { quiet_ = std::max(quiet_, now); }
  /// A deadline was handed in, after all that had come.
  void note_judged(Instant now);
  void note_sent(std::uint8_t client, const Octets& adu, Instant now);
  /// All that is to be done now is done, and time goes on.
  void note_passing(Instant now, bool is_undisturbed);
  /// The driver does nothing for a while.
  void note_sleep() { has_slept_ = true; }
  /// An answer was handed in damaged.
  void note_damaged(Flight& flight, Instant now);
  /// Nothing will ever happen any more.
  void note_end();

  /// A transmission whose answer was waited for until it was cut, once.
  std::optional<std::uint16_t> take_cut() { return std::exchange(cut_, std::nullopt); }

  /// Answers to clients that are wrong because nobody could know yet that a device answers twice.
  [[nodiscard]] unsigned learning() const { return learning_; }
  [[nodiscard]] const std::string& violation() const { return violation_; }
  void report(const std::string& what) { violation_ = violation_.empty() ? what : violation_; }

  [[nodiscard]] std::vector<Flight>& flights() { return flights_; }
  [[nodiscard]] const std::vector<Flight>& flights() const { return flights_; }
  /// The last instant at which an answer that is late may come: later ones nobody can tell from
  /// answers to what was asked since.
  [[nodiscard]] Instant end_of(const Flight& flight) const { return flight.due + hold_; }
  /// The last instant at which the rest of an answer may come whose first half has.
  [[nodiscard]] Instant rest_end_of(const Flight& flight) const {
    return *flight.half_at + times_.of(answer_of(flight).size()) + slack_;
  }
  /// The end of the silence behind what was heard last.
  [[nodiscard]] Instant silent_at() const { return quiet_ + silence_; }
  [[nodiscard]] Duration silence() const { return silence_; }
  /// Something was not answered in time, or the driver was late: requests may have to wait.
  [[nodiscard]] bool is_disturbed() const { return is_disturbed_ || has_slept_; }
  /// An answer is waited for.
  [[nodiscard]] bool is_running() const { return running_.has_value(); }
  /// Instants at which something changes that is about requests that are open, or to come.
  void add_edges(std::vector<Instant>& edges, bool may_be_asked) const;

  void read(StateHash& hash) const;

 private:
  struct Book {
    Instant held_until = Instant::min();  ///< by its last unanswered transmission
    bool stop_unanswered = false;         ///< the last thing that it was told
    unsigned unanswered = 0;              ///< in a row
    Instant offline_at = Instant::min();
    bool is_stopped = false;  ///< a stop was answered, and no write was transmitted since it was
    Instant stopped_at = Instant::min();
    std::uint64_t done = 0;  ///< the last transmission of a write or stop that was acknowledged
    std::optional<std::uint16_t> answered{};  ///< the last transmission that was,
    Instant answered_at = Instant::min();     ///< and when
    Duration shortest_answer = Duration::max();
    Instant sudden_until = Instant::min();  ///< an answer that came sooner may be an earlier one's
    Instant heard_at = Instant::min();
    Instant owes_until = Instant::min();  ///< it is held for what it may owe
    Instant forgets_at = Instant::min();  ///< what it owes is lost then
    std::uint64_t last_heard = 0;         ///< what was heard last answers this transmission
    bool answers_twice = false;
    std::uint64_t taught = 0;  ///< when a second answer was seen to be one, among all events
    Duration second_after{0};  ///< an answer, at most, of those
  };

  [[nodiscard]] const drive::DeviceTiming& timing() const { return plant_.device().timing; }
  [[nodiscard]] bool is_offline(std::uint8_t device) const {
    return timing().offline_after != 0 && books_[device].unanswered >= timing().offline_after;
  }
  [[nodiscard]] bool takes_part(const Request& request, const Flight& flight) const;
  [[nodiscard]] Flight* running() { return running_ ? &flights_[*running_] : nullptr; }
  [[nodiscard]] bool is_repeated(const Request& request, Instant now) const;
  [[nodiscard]] bool is_same_request(const Flight& a, const Flight& b) const;
  void cancel_writes(std::uint8_t device);
  void end_uncertain();
  void note_frame(Flight& flight, Instant now);
  void hold(Flight& closed, Instant now);
  void forget(std::uint8_t device, Instant now);
  [[nodiscard]] Instant sent_at(const Flight& flight) const;
  [[nodiscard]] Instant end_of_tail(const Flight& flight) const {
    return flight.spoilt ? flight.due : end_of(flight);
  }
  void note_wrong(std::uint8_t device, const char* what);
  void end_running(Instant now, bool counts);
  [[nodiscard]] bool is_cut_at(const Flight& running, Instant now) const;
  [[nodiscard]] bool is_waited_for(const Flight& flight);

  // oracle_wire.cpp
  std::optional<Flight> understand(const Octets& frame, Instant now);
  void check_overlap(Instant now);
  void check_hold(const Flight& flight, Instant now);
  void check_stops_first(const Flight& flight, Instant now);
  void check_asked_for(const Flight& flight, Instant now);

  // oracle_state.cpp
  [[nodiscard]] bool is_live(const Flight& flight) const;
  void read(const Flight& flight, StateHash& hash) const;
  void read(const Book& book, StateHash& hash) const;

  // oracle_answers.cpp
  void check_read(const Request& request, const Octets& pdu, Instant now);
  void check_write(const Request& request);
  void check_busy(const Request& request, Instant now);
  void check_no_answer(const Request& request);
  void check_waiting(const Request& request, Instant now);

  const Plant& plant_;
  world::WireTimes times_;
  Duration silence_;
  Duration slack_;  ///< that an answer may pause
  Duration
      hold_;  ///< from the response timeout to the end of the quarantine, and of what adapters keep
  std::array<Request, kSlots> requests_{};
  std::vector<Flight> flights_;
  std::array<Book, kDevices> books_{};
  std::optional<std::uint16_t> cut_;
  std::optional<std::size_t> running_;  ///< the transmission that is waited for
  Instant quiet_ = Instant::min();
  bool has_slept_ = false;
  std::uint64_t events_ = 0;
  bool is_disturbed_ = false;
  unsigned learning_ = 0;
  Duration longest_answer_{0};
  std::string violation_;
};

}  // namespace mbgate::explore

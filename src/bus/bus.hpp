// SPDX-License-Identifier: Apache-2.0
// A bus: a scheduler over a line discipline. It takes jobs, decides which goes next, repeats reads
// and stops, keeps deadlines, leaves devices alone that owe an answer or are offline, answers what
// can be answered together or from memory, and reopens a lost line. Pure: after every call the
// owner empties poll() and asks next_wake().
#pragma once

#include <span>
#include <vector>

#include "bus/action_queue.hpp"
#include "bus/adapter_watch.hpp"
#include "bus/bus_action.hpp"
#include "bus/bus_queue.hpp"
#include "bus/device_table.hpp"
#include "bus/line_discipline.hpp"
#include "bus/line_quality.hpp"
#include "bus/link_state.hpp"
#include "bus/probes.hpp"
#include "bus/state_reader.hpp"

namespace mbgate::bus {

class Bus {
 public:
  /// `devices` are those of this bus; other addresses get the bus's own times.
  Bus(const BusSettings& settings, std::span<const drive::Device> devices);
  Bus(const Bus&) = delete;  // its parts refer to each other
  Bus& operator=(const Bus&) = delete;

  /// Asks for the line. Jobs wait until the first attempt to open it has succeeded or failed.
  void start();
  void handle_opened(Instant now, LineKind kind = LineKind::virtual_line);
  /// The line could not be opened, or died: what was on the wire and what waits ends; reopening is
  /// scheduled. A connection that has answered and was closed by its far end is opened again when
  /// somebody asks, at once if somebody waits already.
  void handle_lost(Instant now, Loss loss = Loss::failed);
  void handle_bytes(modbus::Bytes bytes, Instant now);
  /// After LookAtLine: what lay in the line has been handed in, and nothing else since.
  void handle_looked(Instant now);
  /// Whoever calls this has handed in before what already lay in the line.
  void handle_deadline(Instant now);

  /// Queues a job, or answers it at once; it lies still until its JobEnded, which may be among the
  /// actions already. False: the queue is full, and the bus does not have the job.
  [[nodiscard]] bool submit(Job& job, Instant now);
  /// Takes a waiting job that is no stop back at once, without a JobEnded.
  void withdraw(Job& job);
  /// Sees to it that nothing more follows of a job that does not wait, once what is on the wire has
  /// ended.
  void abandon(Job& job);
  /// The same line with other rules, or other devices: what is known of addresses is kept. Jobs
  /// that wait for devices that are no longer what they were must have been withdrawn.
  void update(const BusSettings& settings, std::span<const drive::Device> devices, Instant now);
  /// No new transmissions but stops: other waiting jobs end as cancelled, running transactions may
  /// finish.
  void stop(Instant now);
  /// After stop(): running transactions end unanswered.
  void give_up(Instant now);

  std::optional<BusAction> poll();
  [[nodiscard]] std::optional<Wake> next_wake() const;

  /// There is a line, or a connection that is opened as soon as somebody asks.
  [[nodiscard]] bool is_open() const { return link_.serves(); }
  /// Between ReopenLine and what becomes of it.
  [[nodiscard]] bool is_reopening() const { return link_.is_reopening(); }
  [[nodiscard]] LineState line_state(Instant now) const { return line_.state(now); }
  [[nodiscard]] std::size_t waiting() const { return queue_.size(); }
  [[nodiscard]] Duration longest_response_timeout() const { return longest_response_timeout_; }
  [[nodiscard]] const BusCounters& counters() const { return counters_; }
  [[nodiscard]] const DeviceCounters& device_counters(std::uint8_t address) const {
    return devices_[address].counters;
  }
  [[nodiscard]] unsigned unanswered_in_row(std::uint8_t address) const {
    return devices_[address].health.unanswered_in_row();
  }
  [[nodiscard]] bool is_offline(std::uint8_t address) const {
    return devices_[address].health.is_offline();
  }
  /// How long the device at the address is still left alone because it owes an answer.
  [[nodiscard]] Duration held_back(std::uint8_t address, Instant now) const;
  /// What the answers of the device at the address are like, and those of all.
  [[nodiscard]] const QualityVerdict& quality(std::uint8_t address) const {
    return quality_[address].verdict();
  }
  [[nodiscard]] QualityVerdict quality() const { return quality_.verdict(); }
  void clear_counters();

 private:
  friend struct mbgate::StateReader;
  /// The job that goes next, when, and whom it passes over.
  struct Choice {
    Job* job;
    Instant at;
    Job* passed_over = nullptr;
  };
  /// Which jobs may go while a stop waits; all of them where none does.
  struct Bounds {
    const Job* before = nullptr;  ///< only those for its device that were accepted before it
    bool beside_stops = false;    ///< only those for devices that no waiting stop is for
  };
  struct Search;

  // bus.cpp: the ends of jobs
  [[nodiscard]] Duration listening_time() const;
  void collect(Instant now);
  void end_running(Ending ending);
  void end_waiting(Ending ending, bool stops_too);
  void end_group(Job& leader, Ending ending);
  void end_job(Job& job, Ending ending);
  void release(Job& job);
  void notify(DeviceNotice::Kind kind, std::uint8_t address);
  void watch_silence(Instant now);

  // bus_link.cpp: the line comes and goes
  void rest(Instant now);
  void handle_cut(Job& job, Instant now);
  void replace(Instant now);
  bool reopen_if_hung(Instant now);
  void wait_for_line();

  // bus_accept.cpp: what becomes of a request before it waits
  void classify(Job& job) const;
  std::optional<Ending> end_at_once(Job& job, Instant now);
  bool take_cached(Job& job, Instant now);
  void note_accepted(Job& job, Instant now);
  void refuse_free_probes(Instant now);
  bool push(Job& job);

  // bus_turns.cpp: what is transmitted when
  void pump(Instant now);
  [[nodiscard]] bool has_looked();
  void expire(Instant now);
  void continue_running(Instant now);
  std::optional<Choice> next_turn(const Bounds& bounds, Instant now);
  std::optional<Choice> choose(const Bounds& bounds, Instant now);
  void begin(const Choice& choice, Instant now);
  void look_for(JobClass job_class, Search& search, Instant now);
  [[nodiscard]] bool is_within(const Bounds& bounds, const Job& job);
  [[nodiscard]] static bool is_between_tries(const Job& job);
  [[nodiscard]] Job* next_repeated(const Bounds& bounds, Instant now);
  [[nodiscard]] bool had_its_turn(const Job& job, Instant now) const;
  [[nodiscard]] bool may_join(const Job& job) const;
  [[nodiscard]] std::size_t in_flight() const;
  [[nodiscard]] std::size_t occupied(Instant now);
  [[nodiscard]] bool is_held_back(const Job& job, Instant now) const;
  [[nodiscard]] Instant held_until(const Job& job) const;
  [[nodiscard]] Instant ready_at(const Job& job) const;

  // bus_transmit.cpp: a transaction goes on the wire
  [[nodiscard]] std::size_t next_transaction(const Job& job) const;
  void skip_known_settings(Job& job);
  void check_allowed(const Job& job, Instant now) const;
  void transmit(Job& job, Instant now);
  drive::DeviceTiming note_transmission(Job& job, Transaction& transaction, Instant now);
  void note_turn(Job& job, DeviceEntry& entry);

  // bus_stops.cpp: stops
  void overtake_writes(const Job& stop, bool let_go_first = false);
  /// Those that were let go before a stop that waits, and are not any more.
  void overtake_writes();
  [[nodiscard]] bool is_stopped_by(const Job& stop, const Job& write) const;
  [[nodiscard]] bool lets_writes_go(const Job& stop) const;
  [[nodiscard]] bool must_let_writes_go(const Job& stop) const;
  std::optional<Instant> next_before(const Job& stop, Instant now);
  [[nodiscard]] Duration held_by(const Job& stop, Instant ready) const;
  [[nodiscard]] Job* in_the_way_of(const Job& stop) const;
  void take_back_held_writes(Instant now);
  void go_on_with_stops(Instant now);
  bool serve_stops(Instant now);
  bool send_stops(Instant now);
  [[nodiscard]] Job* next_stop();
  bool transmit_stop(Job& stop, Instant now);
  [[nodiscard]] Instant stop_overdue_at(const Job& stop) const;
  [[nodiscard]] bool gives_way(const Job& stop, Instant now) const;
  [[nodiscard]] bool was_passed(const Job& stop) const;
  [[nodiscard]] bool waits_patiently(const Job& stop) const;
  std::optional<Choice> turn_before(const Job& stop, Instant now);
  void handle_stop_failure(Job& stop, Instant now);
  void repeat_stop(Job& stop, Instant now);
  void part_from_untried(Job& stop);
  void give_up_stop(Job& stop);

  // bus_ends.cpp: what becomes of a transmission
  void handle_end(const LineEnd& end, Instant now);
  void handle_response(Job& job, const LineEnd& end, Instant now);
  void handle_silence(Job& job, const LineEnd& end, Instant now);
  void handle_failure(Job& job, Instant now);
  void note_quality(const LineEnd& end, std::uint8_t address);
  void tell_quality(std::uint8_t address);
  /// Of writes that were to be repeated, and may not be any more.
  void end_repeats();
  void go_offline(DeviceEntry& entry, std::uint8_t address, Instant now);
  void advance(Job& job, Ending ending);
  void finish(Job& job, Ending ending);

  // bus_unsolicited.cpp: frames that answer nothing
  void handle_unsolicited(const UnsolicitedFrame& unsolicited);
  void note_foreign(const UnsolicitedFrame& unsolicited);
  void note_denied_echo(bool was_heard);

  // bus_groups.cpp: reads that share a transmission
  void share_response(Job& leader);
  void remember(const Job& job);
  void split_up(Job& leader, Ending how);
  void end_over(Instant now);
  void watch_deadlines();
  void drop_followers(Job& leader, Instant now);
  [[nodiscard]] std::optional<Ending> over(const Job& job, Instant now) const;
  void hand_over(Job& leader, Ending ending);

  BusSettings settings_;
  DeviceTable devices_;
  Duration longest_response_timeout_;
  BusCounters counters_;
  LineDiscipline line_;
  BusQueue queue_;
  Probes probes_;
  bool stopping_ = false;
  std::vector<Job*> running_;  // from their first transmission until they end
  std::size_t most_running_;
  bool quarantines_;                  // late answers cannot be told apart
  std::uint64_t sequence_ = 0;        // of the job that was accepted last
  unsigned writes_in_row_ = 0;        // transmitted since the last read
  std::uint64_t turn_ = 0;            // of the last transmission
  std::uint64_t other_turn_ = 0;      // of the last one that was no stop
  std::uint8_t last_address_ = 0;     // that of the last turn
  std::uint64_t turn_of_others_ = 0;  // the last one of another address than that
  const Job* let_by_ = nullptr;       // on the wire between two tries of a stop
  bool never_silent_reported_ = false;
  bool foreign_reported_ = false;
  bool replacement_reported_ = false;
  LineQuality quality_;
  bool frame_heard_ = false;    // a stray one, since a transmission ended last
  bool own_heard_ = false;      // the own request, since a transmission ended last
  unsigned denied_echoes_ = 0;  // so many in a row: a read that is answered without one ends it
  Instant pumped_at_;
  std::optional<Wake> next_start_;  // when a transmission may begin, as seen at pumped_at_
  enum class Looking : std::uint8_t { no, asked, done } looking_ = Looking::no;
  AdapterWatch adapter_;
  LinkState link_;
  ActionQueue<BusAction> actions_;
};

}  // namespace mbgate::bus

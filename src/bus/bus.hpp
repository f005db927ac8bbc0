// SPDX-License-Identifier: Apache-2.0
// A bus: a scheduler over a line discipline. It takes jobs, decides which goes next, repeats reads
// and stops, keeps deadlines, leaves devices alone that owe an answer or are offline, answers what
// can be answered together or from memory, and reopens a lost line. Pure: after every call the
// owner empties poll() and asks next_deadline().
#pragma once

#include <span>
#include <variant>
#include <vector>

#include "bus/action_queue.hpp"
#include "bus/bus_queue.hpp"
#include "bus/device_table.hpp"
#include "bus/line.hpp"

namespace mbgate::bus {

struct OpenLine {};
struct TransmitFrame {
  FrameBytes frame;
};
struct JobEnded {
  Job* job;
  Ending ending;
};
/// An own transmission was heard differently than it was sent.
struct EchoDiffered {};
/// What comes in cannot be followed any further. The bus has given the line up already: nothing
/// needs to be reported back.
struct CloseLine {};
/// What was learned of the device at an address.
struct DeviceNotice {
  enum class Kind : std::uint8_t {
    lost,            ///< it does not answer: offline
    back,            ///< it answers again
    late,            ///< an answer came after its time, and the quarantine grew
    early,           ///< an answer began before its time: response_wait is set too long
    foreign,         ///< a frame that nobody asked for: another client is on this line
    stop_unanswered  ///< a stop was repeated as often as allowed, without a fitting echo
  };
  Kind kind;
  std::uint8_t address;
  Duration lateness{0};    ///< late: after the response timeout
  Duration quarantine{0};  ///< late: in force from now on
};
using BusAction =
    std::variant<OpenLine, TransmitFrame, JobEnded, EchoDiffered, CloseLine, DeviceNotice>;

class Bus {
 public:
  /// `devices` are those of this bus; other addresses get the bus's own times.
  Bus(const BusSettings& settings, std::span<const drive::Device> devices);
  Bus(const Bus&) = delete;  // its parts refer to each other
  Bus& operator=(const Bus&) = delete;

  /// Asks for the line. Jobs wait until the first attempt to open it has succeeded or failed.
  void start();
  void handle_opened(Instant now);
  /// The line could not be opened, or died: what was on the wire and what waits ends; reopening is
  /// scheduled.
  void handle_lost(Instant now);
  void handle_bytes(modbus::Bytes bytes, Instant now);
  void handle_deadline(Instant now);

  /// Is this a stop of the device at the address, or of one that hears the broadcast?
  [[nodiscard]] bool is_stop(std::uint8_t address, const modbus::Request& request,
                             drive::BroadcastForm broadcast) const;
  /// Queues a job, or answers it at once; it lies still until its JobEnded, which may be among the
  /// actions already. False: the queue is full, and the bus does not have the job.
  [[nodiscard]] bool submit(Job& job, Instant now);
  /// Takes a waiting job that is no stop back at once, without a JobEnded.
  void withdraw(Job& job);
  /// The same line with other rules, or other devices: what is known of addresses is kept. Jobs
  /// that wait for devices that are no longer what they were must have been withdrawn.
  void update(const BusSettings& settings, std::span<const drive::Device> devices, Instant now);
  /// No new transmissions but stops: other waiting jobs end as cancelled, running transactions may
  /// finish.
  void stop(Instant now);
  /// After stop(): running transactions end unanswered.
  void give_up(Instant now);

  std::optional<BusAction> poll();
  [[nodiscard]] std::optional<Instant> next_deadline() const;

  [[nodiscard]] bool is_open() const { return state_ == State::open; }
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
  void clear_counters();

 private:
  enum class State : std::uint8_t {
    starting,  ///< the first attempt to open the line runs
    closed,    ///< no line; the next attempt is scheduled or runs
    open
  };
  /// The job that goes next, when, and whom it passes over.
  struct Choice {
    Job* job;
    Instant at;
    Job* passed_over = nullptr;
  };
  struct Search;

  // bus.cpp: the line and the queue
  [[nodiscard]] Duration listening_time() const;
  void collect(Instant now);
  void end_running(Ending ending);
  void end_waiting(Ending ending, bool stops_too);
  void end_group(Job& leader, Ending ending);
  void end_job(Job& job, Ending ending);
  void release(Job& job);
  void notify(DeviceNotice::Kind kind, std::uint8_t address);

  // bus_accept.cpp: what becomes of a request before it waits
  void classify(Job& job) const;
  std::optional<Ending> end_at_once(Job& job, Instant now);
  bool take_cached(Job& job, Instant now);
  [[nodiscard]] bool may_probe(const DeviceEntry& entry, Instant now) const;
  bool push(Job& job);

  // bus_turns.cpp: what is transmitted when
  void pump(Instant now);
  void expire(Instant now);
  void continue_running(Instant now);
  std::optional<Choice> choose(Instant now);
  void look_for(JobClass job_class, Search& search, Instant now);
  [[nodiscard]] bool may_join(const Job& job) const;
  [[nodiscard]] std::size_t in_flight() const;
  [[nodiscard]] std::size_t occupied(Instant now);
  [[nodiscard]] bool is_held_back(const Job& job, Instant now) const;
  [[nodiscard]] Instant held_until(const Job& job) const;
  [[nodiscard]] Instant ready_at(const Job& job) const;
  void skip_known_settings(Job& job);
  void transmit(Job& job, Instant now);
  drive::DeviceTiming note_transmission(Job& job, Transaction& transaction, Instant now);

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
  bool serve_stops(Instant now);
  void repeat_stop(Job& stop, Instant now);

  // bus_ends.cpp: what becomes of a transmission
  void handle_end(const LineEnd& end, Instant now);
  void handle_response(Job& job, const LineEnd& end, Instant now);
  void handle_silence(Job& job, const LineEnd& end, Instant now);
  void handle_failure(Job& job, Instant now);
  void handle_stray(const Stray& stray, Instant now);
  void note_probe(Job& job, Instant now);
  void go_offline(DeviceEntry& entry, std::uint8_t address, Instant now);
  void advance(Job& job, Ending ending);
  void finish(Job& job, Ending ending);

  // bus_groups.cpp: reads that share a transmission
  void share_response(Job& leader);
  void remember(const Job& job);
  void split_up(Job& leader);
  void end_over(Instant now);
  void drop_followers(Job& leader, Instant now);
  [[nodiscard]] std::optional<Ending> over(const Job& job, Instant now) const;
  void hand_over(Job& leader, Ending ending);

  BusSettings settings_;
  DeviceTable devices_;
  Duration longest_response_timeout_;
  BusCounters counters_;
  Line line_;
  BusQueue queue_;
  State state_ = State::starting;
  bool stopping_ = false;
  std::vector<Job*> running_;  // from their first transmission until they end
  std::size_t most_running_;
  bool quarantines_;                     // late answers cannot be told apart
  std::uint64_t sequence_ = 0;           // of the job that was accepted last
  unsigned writes_in_row_ = 0;           // transmitted since the last read
  Instant next_probe_ = Instant::min();  // of all devices
  bool foreign_reported_ = false;
  Instant pumped_at_;
  std::optional<Instant> next_start_;  // when a transmission may begin, as seen at pumped_at_
  Instant opened_at_;
  std::optional<Instant> reopen_at_;
  Duration reopen_delay_;
  ActionQueue<BusAction> actions_;
};

}  // namespace mbgate::bus

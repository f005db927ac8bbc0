// SPDX-License-Identifier: Apache-2.0
// A bus: a scheduler over a line discipline. It takes jobs, decides which goes next, repeats reads,
// keeps deadlines, and reopens a lost line. Pure: after every call the owner empties poll() and
// asks next_deadline().
#pragma once

#include <array>
#include <deque>
#include <span>
#include <variant>

#include "bus/bus_queue.hpp"
#include "bus/rtu_line.hpp"

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
using BusAction = std::variant<OpenLine, TransmitFrame, JobEnded, EchoDiffered>;

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

  /// Queues a job; it lies still until its JobEnded. False: the queue is full, the job is
  /// untouched.
  [[nodiscard]] bool submit(Job& job, Instant now);
  /// Takes a waiting job back at once, without a JobEnded.
  void withdraw(Job& job) { queue_.remove(job); }
  /// No new transmissions: waiting jobs end as cancelled, the running transaction may finish.
  void stop(Instant now);
  /// After stop(): the running transaction ends unanswered.
  void give_up(Instant now);

  std::optional<BusAction> poll();
  [[nodiscard]] std::optional<Instant> next_deadline() const;

  [[nodiscard]] bool is_open() const { return state_ == State::open; }
  [[nodiscard]] RtuLine::State line_state(Instant now) const { return line_.state(now); }
  [[nodiscard]] std::size_t waiting() const { return queue_.size(); }
  [[nodiscard]] Duration longest_response_timeout() const { return longest_response_timeout_; }
  [[nodiscard]] const BusCounters& counters() const { return counters_; }
  [[nodiscard]] const DeviceCounters& device_counters(std::uint8_t address) const {
    return device_counters_[address];
  }
  void clear_counters();

 private:
  enum class State : std::uint8_t {
    starting,  ///< the first attempt to open the line runs
    closed,    ///< no line; the next attempt is scheduled or runs
    open
  };

  void pump(Instant now);
  bool end_if_over(Job& job, Instant now);
  [[nodiscard]] Job* next_job();
  void transmit(Job& job, Instant now);
  void collect();
  void handle_end(RtuLine::End how);
  void handle_response(Job& job);
  void handle_failure(Job& job);
  void end_job(Job& job, Ending ending);
  void end_waiting(Ending ending);
  void expire(Instant now);
  [[nodiscard]] const drive::DeviceTiming& timing_of(const Job& job) const;
  [[nodiscard]] DeviceCounters& counters_of(const Job& job);

  BusSettings settings_;
  std::array<drive::DeviceTiming, modbus::kMaxDeviceAddress + 1> timings_;
  Duration longest_response_timeout_;
  BusCounters counters_;
  std::array<DeviceCounters, modbus::kMaxDeviceAddress + 1> device_counters_{};
  RtuLine line_;
  BusQueue queue_;
  State state_ = State::starting;
  bool stopping_ = false;
  Job* running_ = nullptr;  // its transaction is on the wire, or must be the next one there
  Instant opened_at_;
  std::optional<Instant> reopen_at_;
  Duration reopen_delay_;
  std::deque<BusAction> actions_;
};

}  // namespace mbgate::bus

// SPDX-License-Identifier: Apache-2.0
// A bus: a scheduler over a line discipline. It takes jobs, decides which is sent next, repeats
// reads and stops, keeps deadlines, sends nothing to devices that owe an answer or are offline,
// shares reads, answers from the cache, and reopens a lost line. Pure: after every call the owner
// empties poll() and asks next_wake().
#pragma once

#include <span>

#include "bus/health/line_diagnosis.hpp"
#include "bus/parts.hpp"
#include "bus/transmission/dispatch.hpp"
#include "bus/transmission/job_ends.hpp"
#include "bus/transmission/outcomes.hpp"

namespace mbgate::bus {

class Bus {
 public:
  /// `devices` are those of this bus; other addresses get the bus's own times.
  Bus(const BusSettings& settings, std::span<const drive::Device> devices)
      : parts_(settings, devices) {}
  Bus(const Bus&) = delete;  // its parts refer to each other
  Bus& operator=(const Bus&) = delete;

  /// Asks for the line. Jobs wait until the first attempt to open it has succeeded or failed.
  void start() { parts_.actions.push(OpenLine{}); }
  void handle_opened(Instant now, LineKind kind = LineKind::virtual_line);
  /// The line could not be opened, or died: what was on the wire and what waits ends; reopening is
  /// scheduled. A connection that has answered and was closed by its far end is opened again when
  /// somebody asks, at once if somebody waits already.
  void handle_lost(Instant now, Loss loss = Loss::failed);
  void handle_bytes(modbus::Bytes bytes, Instant now);
  /// The driver of the line holds so many bytes that it has not sent, from now on.
  void note_unsent(std::size_t bytes);
  /// After LookAtLine: what lay in the line has been handed in, and nothing else since.
  void handle_looked(Instant now);
  /// Whoever calls this has handed in before what already lay in the line.
  void handle_deadline(Instant now);

  /// Queues a job, or answers it at once; it has a stable address until its JobEnded, which may be
  /// among the actions already. False: the queue is full, and the bus does not have the job.
  [[nodiscard]] bool submit(Job& job, Instant now);
  /// Takes a waiting job that is no stop back at once, without a JobEnded.
  void withdraw(Job& job);
  /// Sees to it that nothing more follows of a job that does not wait, once what is on the wire has
  /// ended; nor of a stop, which is not sent any more.
  void abandon(Job& job);
  /// The same line with other rules, or other devices: what is known of addresses is kept. Jobs
  /// that wait for devices that are no longer what they were must have been withdrawn.
  void update(const BusSettings& settings, std::span<const drive::Device> devices, Instant now);
  /// Another bus had the same port before: what is owed there is owed to this one.
  void take_over(Bus& before, Instant now);
  /// No new transmissions but stops: other waiting jobs end as cancelled, running transactions may
  /// finish.
  void stop(Instant now);
  /// After stop(): running transactions end unanswered.
  void give_up(Instant now);

  std::optional<BusAction> poll() { return parts_.actions.poll(); }
  /// The first instant that it waits for.
  [[nodiscard]] std::optional<Wake> next_wake() const;

  [[nodiscard]] const LinkState& link() const { return parts_.link; }
  [[nodiscard]] const BusCounters& counters() const { return parts_.counters; }
  /// What is known of each address.
  [[nodiscard]] const DeviceTable& devices() const { return parts_.devices; }
  /// All of it, to be shown: what waits, what is on the wire, the state of the line.
  [[nodiscard]] const Parts& parts() const { return parts_; }
  /// What was noticed of the line: what the answers are like, how busy it is, other clients.
  [[nodiscard]] const LineDiagnosis& diagnosis() const { return diagnosis_; }
  void clear_counters();
  /// From now on each transmission is told, or none any more. Nothing else depends on it.
  void set_traced(bool traced) { parts_.is_traced = traced; }

 private:
  void collect(Instant now);

  Parts parts_;
  /// Since this bus, or the one before, opened the port for the first time.
  std::optional<Instant> listens_first_until_;
  JobEnds ends_{parts_};
  LineDiagnosis diagnosis_{parts_};
  Outcomes outcomes_{parts_, ends_, diagnosis_};
  Dispatch dispatch_{parts_, ends_, outcomes_, diagnosis_};
  std::uint64_t sequence_ = 0;  // of the job that was accepted last
};

}  // namespace mbgate::bus

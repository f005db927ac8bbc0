// SPDX-License-Identifier: Apache-2.0
// A client request from its acceptance to its answer, and what its jobs have come to so far.
#pragma once

#include <algorithm>
#include <boost/container/small_vector.hpp>
#include <deque>
#include <optional>
#include <vector>

#include "bus/job.hpp"
#include "gateway/client_session.hpp"
#include "gateway/settings_snapshot.hpp"
#include "routing/plan.hpp"

namespace mbgate::gateway {

/// Failsafe writes on their way.
struct FailsafeRun {
  struct Write {
    const bus::Job* job;  ///< nullptr: it has ended
    std::size_t place;    ///< among the device's failsafe writes
  };
  Failsafe::Due due;  ///< the place of its device is that of the settings in force
  std::vector<Write> unsent;
  /// The device has other failsafe writes now: unless all of these are sent, all of those are due.
  bool is_outdated = false;

  /// The job is no more.
  void forget(const bus::Job& job) {
    for (Write& write : unsent) {
      write.job = write.job == &job ? nullptr : write.job;
    }
  }
};

/// Failsafe writes are one too: without a client and without a plan.
struct Exchange {
  struct Part {
    BusId bus;
    bus::Job* job;
    /// As its bus has found it.
    [[nodiscard]] bool is_stop() const { return job->job_class == bus::JobClass::stop; }
  };

  SettingsSnapshot* snapshot = nullptr;  ///< that the plan was made with
  ClientId client{};
  ListenerId listener{};                       ///< as the settings in force count them
  std::optional<drive::WordOrder> word_order;  ///< that its route asked for
  routing::ClientAddress address;
  bool client_gone = false;
  bool is_stop = false;  ///< one of its parts is: that one goes on without its client
  /// Of a stop that is one on some buses only: those on which its part may not be transmitted.
  boost::container::small_vector<BusId, 1> left_out;
  std::optional<FailsafeRun> failsafe;
  ClientSession::AnswerId answer{};
  modbus::MbapHeader header;
  routing::BroadcastReply reply = routing::BroadcastReply::echo;
  std::optional<routing::Plan> plan;
  boost::container::small_vector<Part, 1> parts;  ///< jobs that have not ended
  std::optional<modbus::Pdu> response;
  bool failed = false;
  bool was_on_wire = false;
  bool wrong_word_order = false;  ///< the drive's own setting is not the one configured
  bool had_no_path = false;       ///< a line was not there and nothing of that part was transmitted

  [[nodiscard]] bool leaves_out(BusId bus) const {
    return std::ranges::find(left_out, bus) != left_out.end();
  }
  /// Takes in what became of a job.
  void note(const bus::Job& job, bus::Ending ending);
  /// The answer, once every part has ended; nothing if none is to be given.
  [[nodiscard]] std::optional<modbus::Pdu> result() const;
};

/// Objects that are handed out and taken back, and lie still meanwhile. Grows to the most ever
/// needed.
template <typename Object>
class Pool {
 public:
  std::uint32_t take() {
    if (free_.empty()) {
      objects_.emplace_back();
      return static_cast<std::uint32_t>(objects_.size() - 1);
    }
    const std::uint32_t index = free_.back();
    free_.pop_back();
    return index;
  }
  void give_back(std::uint32_t index) {
    objects_[index] = Object{};
    free_.push_back(index);
  }
  Object& operator[](std::uint32_t index) { return objects_[index]; }
  /// Those that are not in use are as new.
  [[nodiscard]] std::deque<Object>& all() { return objects_; }
  [[nodiscard]] std::size_t in_use() const { return objects_.size() - free_.size(); }

 private:
  std::deque<Object> objects_;
  std::vector<std::uint32_t> free_;
};

}  // namespace mbgate::gateway

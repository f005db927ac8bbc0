// SPDX-License-Identifier: Apache-2.0
// Writes what goes into the machine and what comes out of it to a file, without ever making the io
// thread wait: lines are gathered there and written by a thread of the recorder's own. If the file
// does not take them fast enough, the recording ends; memory does not grow, and no bus waits.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "gateway/recording/record.hpp"
#include "io/unique_fd.hpp"

namespace mbgate::io {

class Recorder {
 public:
  /// Bytes that may wait for the file: seconds of the busiest plant.
  static constexpr std::size_t kMostWaiting = 16'000'000;
  /// Called on the io thread, once, if the recording ends before end() or the destructor.
  using OnEnded = std::function<void(const std::string& why)>;

  /// `head` is what head_lines() gives.
  Recorder(UniqueFd file, const std::string& head, OnEnded on_ended);
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;
  /// Does not wait. What was handed over is still written, if the process lives long enough.
  ~Recorder();

  /// The machine was made: the head ends here.
  void begin(gateway::Instant start);
  void note(const gateway::Input& input, gateway::Instant at);
  void note(const gateway::Action& action, const gateway::Settings& settings);
  /// After each turn: gives the lines noted so far to the writing thread, now or, if that thread is
  /// just taking others, at the next call.
  void hand_over();
  /// Nothing is noted any more; the file says why.
  void end(const std::string& why);
  /// Waits until everything noted is in the file. False if that takes longer than `limit` or cannot
  /// be done; nothing is noted any more in any case.
  bool close(std::chrono::milliseconds limit);

 private:
  struct Shared;
  static void write_until_closed(const std::shared_ptr<Shared>& shared);
  void give(Shared& shared);
  void fail(const std::string& why);

  std::shared_ptr<Shared> shared_;
  std::string noted_;
  bool ended_ = false;
  OnEnded on_ended_;
};

}  // namespace mbgate::io

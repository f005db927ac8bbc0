// SPDX-License-Identifier: Apache-2.0
// Writes the inputs and actions of the machine to a file without ever blocking the io thread. Lines
// are collected there and written by a thread of the recorder. If the file does not take them fast
// enough, the recording ends: memory does not grow, and no bus waits.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "report/recording/record.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::io {

class Recorder {
 public:
  /// Bytes that may wait for the file: a few seconds of the busiest plant.
  static constexpr std::size_t kMostWaiting = 16'000'000;
  /// Called on the io thread, once, if the recording ends before end() or the destructor.
  using OnEnded = std::function<void(const std::string& why)>;

  /// `head` is what head_lines() gives.
  Recorder(sys::UniqueFd file, const std::string& head, OnEnded on_ended);
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;
  /// Does not wait. What was handed over is still written if the process lives long enough.
  ~Recorder();

  /// The machine was constructed: the head ends here.
  void begin(gateway::Instant start);
  void note(const gateway::Input& input, gateway::Instant at);
  void note(const gateway::Action& action, const gateway::Settings& settings);
  /// To be called after each turn: gives the lines noted so far to the writing thread. If that
  /// thread is just taking others, it is done at the next call.
  void hand_over();
  /// Ends the recording; the file says why.
  void end(const std::string& why);
  /// Ends the recording and waits until all of it is in the file. False if that takes longer than
  /// `limit` or fails.
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

// SPDX-License-Identifier: Apache-2.0
// Modbus RTU servers on ptys whose answers come when the test wants them, or as soon after that as
// the machine lets them, or never. One server a line; it answers in the order of the requests,
// function 03 only.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace mbgate::test {

class ScriptedDevices {
 public:
  using Clock = std::chrono::steady_clock;
  using Delay =
      std::optional<std::chrono::microseconds>;  ///< from the end of the request; or never

  /// Reads of this register are answered with the number of requests that the server had so far.
  static constexpr unsigned kRequests = 0xFFFF;
  /// What every other register holds: its own address.
  static constexpr unsigned value_of(unsigned address) { return address; }

  explicit ScriptedDevices(int lines);
  ~ScriptedDevices();
  ScriptedDevices(const ScriptedDevices&) = delete;
  ScriptedDevices& operator=(const ScriptedDevices&) = delete;

  /// The path of the near side.
  [[nodiscard]] std::string path(int line) const;
  /// Keeps all answers back from now on, or no longer. They are not late then.
  void hold(bool holds) { holds_ = holds; }
  /// How the next requests that begin at the address are answered, in turn; others after 2 ms.
  void plan(int line, unsigned address, std::deque<Delay> delays);
  /// Waits until all planned answers were given; false if this takes longer than anything may.
  [[nodiscard]] bool all_given(int line);
  /// When the near side could read the last planned answer; nothing if another request came first.
  [[nodiscard]] std::optional<Clock::time_point> readable_at(int line);
  [[nodiscard]] unsigned requests(int line) const;

 private:
  struct Pending {
    Clock::time_point due;
    std::vector<unsigned char> frame;
    bool is_planned;
    unsigned request;  ///< its number
  };
  struct Watch {
    unsigned request;  ///< the last one before the answer
    Clock::time_point since;
  };
  struct Line {
    int far = -1;
    int near = -1;
    std::string path;
    std::vector<unsigned char> received;
    std::deque<Pending> pending;
    std::map<unsigned, std::deque<Delay>> plans;
    std::atomic<unsigned> requests{0};
    unsigned to_come = 0;        ///< planned answers
    std::optional<Watch> watch;  ///< of the last one
    std::optional<Clock::time_point> readable_at;
  };

  void serve();
  void read_requests(Line& line);
  void take_request(Line& line);
  void answer_due(Line& line);
  void watch_planned(Line& line);
  [[nodiscard]] int wait_ms() const;

  std::deque<Line> lines_;
  std::mutex mutex_;  // of the plans and of what became of them
  std::condition_variable planned_given_;
  std::atomic<bool> stop_{false};
  std::atomic<bool> holds_{false};
  std::thread thread_;
};

}  // namespace mbgate::test

// SPDX-License-Identifier: Apache-2.0
// The devices and the wires: takes requests from ptys, answers them at the instants at which a wire
// of that baud rate would, and measures the other side from there.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "moment.hpp"
#include "plant.hpp"
#include "sim/program/pty.hpp"

namespace mbgate::bench {

/// What the wire saw of one bus while it was measured.
struct WireFigures {
  std::uint64_t transactions = 0;  ///< answered ones
  Moment first{};                  ///< the end of the first one's response
  Moment last{};
  std::uint64_t violations = 0;  ///< requests that began before t3.5 was over
  std::uint64_t bad_frames = 0;  ///< what was no request for the plant
  /// From the moment when the next request could have started to the one when it did.
  Samples dead_time;
  /// How much later than its instant the last byte of a response was written.
  Samples lateness;

  /// Transactions a second, from the first to the last, so that it does not matter how the time of
  /// the measurement cuts them; but not more than that time can have had.
  [[nodiscard]] double rate(double seconds) const;
};

/// Runs in one thread of its own from start() to end().
class BusSimulator {
 public:
  /// Makes a pty for each bus, with links in `folder`. Throws std::runtime_error.
  BusSimulator(const Plant& plant, const std::filesystem::path& folder);
  ~BusSimulator();
  BusSimulator(const BusSimulator&) = delete;
  BusSimulator& operator=(const BusSimulator&) = delete;

  /// "/dev/pts/7": what a gateway is given.
  [[nodiscard]] std::vector<std::string> paths() const;
  /// Starts the thread. Before it, the process may still fork.
  void start();
  /// From here on it counts.
  void begin() { measuring_ = true; }
  /// Ends the thread; one entry a bus.
  std::vector<WireFigures> end();

 private:
  struct Bus {
    sim::Pty pty;
    unsigned number;
    Frame received{};
    Moment began{};        ///< the first byte of `received`
    Frame response{};      ///< on the wire; empty: none
    std::size_t sent = 0;  ///< bytes of `response`
    Moment response_at{};  ///< its first bit
    Moment free_at{};      ///< the next request may start
    bool answered =
        false;  ///< the last one was, so that free_at is what the other side can see too
    WireFigures figures{};
  };

  void run();
  /// Writes what is due; the instant at which the bus wants to be looked at again.
  Moment advance(Bus& bus);
  void take(Bus& bus, const std::vector<std::uint8_t>& bytes, Moment at);
  void take_request(Bus& bus, Moment at);
  /// Until something was received or `next` is there.
  void wait(Moment next);

  Plant plant_;
  std::vector<Bus> buses_;
  std::thread thread_;
  std::atomic<bool> measuring_ = false;
  std::atomic<bool> ending_ = false;
};

}  // namespace mbgate::bench

// SPDX-License-Identifier: Apache-2.0
// The process around the gateway, as late and clumsy as a loaded machine makes it: it wakes up late
// and in bunches, takes what is ready in any order, is interrupted between two things, and calls
// when there is no need. What comes meanwhile waits in the kernel. It keeps its promise: what lies
// in a line's descriptor is handed in before each deadline and each transmission. For the end of a
// silence it wakes up early and watches the line.
#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "world/random.hpp"
#include "world/schedule.hpp"

namespace mbgate::world {

/// Each chance in thousandths, of wake-ups unless it says otherwise.
struct DriverManners {
  unsigned late = 0;  ///< by up to 20 ms
  unsigned slow = 0;  ///< of the things it does: then it is interrupted for up to 2 ms
  unsigned spurious = 0;
  bool stalls = false;  ///< now and then, for up to 500 ms
  bool stops = false;   ///< now and then it is stopped for longer, and notices it
  bool any_order = false;
  Duration usual{0};  ///< it takes up to so long to wake up at all
};
/// How a machine of chance treats it; whether it is stopped has a chance of its own.
DriverManners draw_driver(Random& random, std::uint64_t seed);

class Driver {
 public:
  using Bytes = std::vector<std::uint8_t>;
  using Handler = std::function<void()>;
  /// What it can do with the gateway, each with all that follows at once.
  struct Hands {
    std::function<void(std::size_t, const Bytes&)> bytes;
    std::function<void(std::size_t)> lost;
    std::function<void()> deadline;
    /// It has not run for so long.
    std::function<void(Duration)> stalled;
    std::function<std::optional<bus::Wake>()> next_wake;
    /// Lets time go on, and what happens meanwhile in the plant happen.
    std::function<void(Duration)> interrupt;
    /// Something of this kind has gone wrong.
    std::function<void(const char*)> fault;
  };
  Driver(const DriverManners& manners, std::size_t buses, std::uint64_t seed, Schedule& schedule,
         Hands hands);

  // The kernel's side.
  /// A line's adapter has received bytes; or is no more.
  void line_bytes(std::size_t bus, const Bytes& bytes);
  void line_lost(std::size_t bus);
  /// The line is opened: from now on it is read.
  void watch_line(std::size_t bus);
  /// Nobody reads it any more; what lies there is lost.
  void forget_line(std::size_t bus);
  /// Something is ready that a client has done.
  void client_ready(Handler handler) { ready({kNoLine, true, std::move(handler)}); }
  /// The same of anything else.
  void post(Handler handler) { ready({kNoLine, false, std::move(handler)}); }
  /// What it does itself as soon as it has done what it is doing.
  void soon(Handler handler) { soon_.push_back(std::move(handler)); }

  // The process's side.
  [[nodiscard]] std::optional<Instant> wakes_at() const {
    return stop_ ? stop_->until : bus::earlier(wakes_, timer_);
  }
  void wake();
  /// The gateway is about to transmit: what lies in the line is handed in first.
  void look(std::size_t bus) {
    if (promises_) {
      read_line(bus);
    }
  }
  /// The gateway may have another deadline.
  void set_timer();
  [[nodiscard]] bool is_awake() const { return awake_; }
  /// Something is about to be done to it by hand: it runs.
  void come_back();
  /// It is not stopped any more.
  void end_stops() {
    manners_.stops = false;
    come_back();
  }
  /// From now on it is punctual.
  void calm_down() {
    come_back();
    manners_ = DriverManners{};
  }
  /// It judges before it reads, which it must not; and it is late.
  void break_promise() {
    promises_ = false;
    manners_.late = kOften;
  }

 private:
  static constexpr std::size_t kNoLine = ~std::size_t{0};
  static constexpr unsigned kOften = 500;
  struct Ready {
    std::size_t line;
    bool is_client;
    Handler handler;
  };
  struct Stop {
    Instant since;
    Instant until;
  };
  struct Line {
    Bytes bytes;
    bool open = false;
    bool lost = false;
    bool listed = false;  ///< among what is ready
  };

  void ready(Ready it);
  [[nodiscard]] bool is_watching() const;
  void list(std::size_t bus);
  void put_in_order(std::vector<Ready>& bunch);
  void read_line(std::size_t bus);
  void judge_deadline();
  void run_soon();
  Duration lateness();

  DriverManners manners_;
  Random random_;
  Random of_stops_;
  Schedule& schedule_;
  Hands hands_;
  std::vector<Line> lines_;
  std::vector<Ready> ready_;
  std::deque<Handler> soon_;
  std::optional<Instant> wakes_;       ///< for what is ready
  std::optional<bus::Wake> deadline_;  ///< as the timer is set
  std::optional<Instant> timer_;       ///< when it will be noticed
  std::optional<Stop> stop_;           ///< it does not run
  bool awake_ = false;
  bool watch_ended_ = false;  ///< bytes came while it waited for the end of a silence
  bool promises_ = true;
  bool unread_ = false;  ///< something may lie in a line's descriptor
};

}  // namespace mbgate::world

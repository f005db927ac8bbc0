// SPDX-License-Identifier: Apache-2.0
// Arranges a plan for what seldom happens. Its lines are quiet, because noise, other settings and
// late processes excuse what must be seen there.
#pragma once

#include <vector>

#include "soak/plan.hpp"

namespace mbgate::soak {

class ThemeDraw {
 public:
  ThemeDraw(SoakPlan& plan, std::uint64_t seed);

  void arrange();

 private:
  /// What of a theme some of its plans are about.
  enum class Part : std::uint8_t {
    usual,
    writers,    ///< of busy lines: reads wait behind writes
    deserters,  ///< of shared reads: who asked goes, and others still want to know
    let_go,     ///< of stops: writes go first, each after its device's gap
    alike,      ///< of stops: identical ones to drives that often do not answer
    between,    ///< of stops: of those that wait between two tries to a dead drive
    several     ///< of stops: of several drives at once, in the midst of runs of writes
  };

  void pick(unsigned which);
  void arrange(std::size_t bus);
  [[nodiscard]] std::vector<std::size_t> fitting_lines();
  [[nodiscard]] std::vector<std::size_t> devices_on(std::size_t bus) const;
  void let_everybody_in();
  void calm(std::size_t bus);
  void let_die(std::size_t bus);
  void set_times(drive::DeviceTiming& timing);
  void be_late(std::size_t bus);
  // plan_slow.cpp
  void be_slow(std::size_t bus);
  void answer_twice(std::size_t bus);
  drive::DeviceTiming& ask_plainly(std::size_t device);
  void ask_all_the_time(std::size_t bus, std::size_t device);
  void omit(std::size_t bus);
  Manners client(std::size_t bus, std::vector<std::size_t> devices);

  // plan_busy_lines.cpp
  void wait_for_turns(std::size_t bus);
  void crowd(std::size_t bus);
  void write_much(std::size_t bus);
  void share(std::size_t bus);
  void stop_much(std::size_t bus);
  void desert(std::size_t bus);

  // plan_stops.cpp
  void stop_behind_writes(std::size_t bus);
  void stop_alike(std::size_t bus);
  void stop_between(std::size_t bus);
  void stop_several(std::size_t bus);
  void add_more(std::size_t bus);
  void set_slow(std::size_t device);

  SoakPlan& plan_;
  Random random_;
  Random calm_;
  Random more_;
  Random ways_;  // what was added to themes later
  Part part_ = Part::usual;
  unsigned hosts_ = 0;
};

}  // namespace mbgate::soak

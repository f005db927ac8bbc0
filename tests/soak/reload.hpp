// SPDX-License-Identifier: Apache-2.0
// Other settings while the gateway runs, as a user's reload would bring them: another order, other
// times and rules, devices that are set otherwise or move, other lines, things that go and return.
//
// Requests are planned when they are written, and mean what the settings say when the gateway takes
// them. So what changes their meaning changes only when each through these doors was at least begun
// before: it is refused then. What makes none of them outdated waits until none is in between.
#pragma once

#include <utility>

#include "soak/arrangement.hpp"
#include "soak/oracle.hpp"
#include "soak/specification.hpp"

namespace mbgate::soak {

/// What a reload does to what is under way.
struct Reload {
  std::vector<std::pair<std::size_t, std::uint8_t>> changed;  ///< bus and address
  std::vector<std::size_t> lines;                             ///< buses whose lines are given up
  std::vector<std::size_t> touched;  ///< buses, as far as times and rules go
  std::vector<std::size_t> idle;     ///< listeners, other idle timeouts
  std::vector<const char*> kinds;    ///< for the list of faults
  [[nodiscard]] bool is_order_only() const { return kinds.empty(); }
};

class Reloads {
 public:
  Reloads(SoakPlan& plan, Oracle::Devices& devices, const Oracle& oracle, std::uint64_t seed);

  [[nodiscard]] bool are_any() const { return every_ > Duration{0}; }
  /// Until the next one; none: this seed has none.
  std::optional<Duration> pause();
  /// Changes the plan's settings.
  Reload draw();
  /// Whatever is absent comes back.
  Reload restore();
  [[nodiscard]] const Arrangement& arrangement() const { return arrangement_; }
  [[nodiscard]] gateway::Settings take_settings() { return arrangement_.take_settings(); }
  /// The same, in the plan's own order from now on.
  [[nodiscard]] gateway::Settings settings_in_order() {
    arrangement_ = Arrangement(plan_);
    return arrangement_.take_settings();
  }

 private:
  /// What a device's requests depend on; the address is 0 while it is absent.
  struct Meaning {
    std::uint8_t address;
    std::optional<drive::WordOrder> word_order;
    drive::Limits limits;
    friend bool operator==(const Meaning&, const Meaning&) = default;
  };

  // reload_rules.cpp: what takes nothing away from any request
  bool change_timing(std::size_t index);
  void draw_timing(drive::DeviceTiming& timing);
  bool change_rules(std::size_t bus);
  bool change_patience(std::size_t bus);
  bool change_listener(std::size_t index);
  bool change_host_limits(std::size_t listener);
  bool change_idle(std::size_t listener);
  bool change_deadline(std::size_t route);
  bool change_failsafe(std::size_t device);

  // reload_windows.cpp
  bool move_windows(std::size_t index);
  bool redraw_windows(Door& door);

  // reload_meaning.cpp: what changes where requests go, or what they say
  bool change_route(std::size_t index);
  bool change_device(std::size_t index);
  bool move(drive::Device& device);
  bool change_line(std::size_t bus);
  [[nodiscard]] bool is_route_settled(std::size_t index) const;
  bool switch_route(std::size_t index);
  bool turn_route(std::size_t index);
  bool switch_device(std::size_t index);
  bool switch_bus(std::size_t index);
  bool switch_listener(std::size_t index);
  bool switch_allowed(std::size_t listener);
  bool change_rights(std::size_t listener);
  bool switch_unwatched(std::size_t index);
  void bring_back();

  template <typename Change>
  void perhaps(unsigned permille, const char* kind, std::size_t count, Change change);
  [[nodiscard]] bool leads_to(const Door& door, std::size_t device) const;
  [[nodiscard]] bool are_settled(std::size_t device) const;
  [[nodiscard]] bool are_within(std::size_t device) const;
  [[nodiscard]] bool are_broadcasts_settled(std::size_t bus) const;
  [[nodiscard]] bool is_sure(std::size_t bus) const;
  [[nodiscard]] std::vector<Meaning> meanings() const;
  void refresh_doors();
  void note_changed();

  SoakPlan& plan_;
  Oracle::Devices& devices_;
  const Oracle& oracle_;
  Random random_;
  Random lines_;
  Random guards_;
  Random patience_;
  Random host_limits_;
  Random windows_;
  Duration every_{0};
  bool is_guarded_ = false;
  Reload reload_;
  std::vector<Meaning> meanings_;                   // in force
  std::vector<std::vector<std::size_t>> buses_of_;  // of each door, if all are there
  Arrangement arrangement_;
};

}  // namespace mbgate::soak

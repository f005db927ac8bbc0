// SPDX-License-Identifier: Apache-2.0
// Makes requests: what a client writes, and what that means to its drive, worked out by rules of
// its own. Every write has words that no other write to its place has.
#pragma once

#include "world/ledger.hpp"
#include "world/plan.hpp"

namespace mbgate::world {

class Asking {
 public:
  Asking(const Plan& plan, Random& random) : plan_(plan), random_(random) {}

  Intent make(const Manners& manners);
  /// A read of registers that live.
  [[nodiscard]] Intent fresh_read(std::size_t door) const;
  /// Asks the gateway's own unit.
  [[nodiscard]] static Intent of_gateway(const Octets& pdu);
  /// Refuses what this host has no right to.
  void check_rights(Intent& intent, std::size_t listener, unsigned host) const;

 private:
  using Words = std::vector<std::uint16_t>;

  [[nodiscard]] std::optional<std::size_t> pick_door(const Manners& manners, bool broadcast);
  [[nodiscard]] Intent begin(std::size_t door, Kind kind) const;
  [[nodiscard]] const Door& door_of(const Intent& intent) const { return plan_.doors[intent.door]; }
  [[nodiscard]] const drive::Device& device_of(const Intent& intent) const {
    return *plan_.device_of(plan_.stations[*door_of(intent).station]);
  }
  static void may_refuse(Intent& intent, unsigned codes);
  static void refuse(Intent& intent, unsigned codes);
  void check_station(Intent& intent, unsigned host) const;
  // Reads.
  Intent read(std::size_t door, bool popular);
  void plan_read(Intent& intent, Table table, unsigned first, unsigned count) const;
  Intent nameless_read(std::size_t door);
  // Writes.
  Intent write(std::size_t door, bool is_plain);
  void registers(Intent& intent, unsigned first, unsigned count);
  void plan_write(Intent& intent, unsigned first, const Words& words) const;
  void single(Intent& intent, unsigned address);
  void single(Intent& intent, unsigned address, unsigned word) const;
  void mask(Intent& intent);
  void read_and_write(Intent& intent);
  void coils(Intent& intent);
  void nameless(Intent& intent);
  Intent stop(std::size_t door);
  Intent broadcast(std::size_t door);
  Intent malformed(std::size_t door);
  [[nodiscard]] std::uint16_t next(std::size_t place, unsigned address);

  const Plan& plan_;
  Random& random_;
  std::unordered_map<std::uint64_t, std::uint16_t> counters_;
};

}  // namespace mbgate::world

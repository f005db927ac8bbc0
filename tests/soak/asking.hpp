// SPDX-License-Identifier: Apache-2.0
// Makes requests: what a client writes, and, worked out by rules of its own, what must go over the
// wire for it. Every write carries values that no other write to its register has.
#pragma once

#include <array>

#include "soak/asked.hpp"
#include "soak/registers.hpp"

namespace mbgate::soak {

using Words = std::vector<std::uint16_t>;

/// Where a request that begins at `first` must end at the latest: within the limit, not beyond a
/// parameter group, and never in a value that does not begin there.
unsigned end_of_piece(Table table, unsigned first, unsigned end, unsigned limit);

/// The words from `first` on in the other word order, but for values that are not whole.
Words exchanged(Words words, unsigned first);
/// Would a write from `first` to before `end` cut a value?
bool cuts_any(unsigned first, unsigned end);
bool touches_value(unsigned first, unsigned end);

class Asking {
 public:
  Asking(const SoakPlan& plan, Random& random);

  /// A request that fits the client's manners, through a door of its listener.
  Asked make(const Manners& manners);
  /// A read that shows that a device is back.
  Asked fresh_read(const Door& door);
  /// Input registers of the status unit.
  static Asked own_read(std::uint16_t first, std::uint16_t count);

 private:
  const Door* door_of(std::size_t listener, bool broadcast);
  const Door& door_for(const Manners& manners);
  Asked malformed(const Door& door);
  Asked for_nobody(const Door& door);
  Asked own();
  Asked health();
  Asked of_gateway(const Manners& manners);
  void refuse_if_read_only(Asked& asked) const;
  [[nodiscard]] bool may_be_silenced(const Door& door, unsigned sub_function) const;
  void check_functions(Asked& asked) const;
  // asking_ends.cpp: what ends behind the last address.
  Asked beyond_last(const Door& door);
  // asking_reads.cpp
  Asked read(const Door& door, bool popular);
  Asked near_read(const Door& door);
  Asked alike_read(const Door& door);
  Asked alike_write(const Door& door);
  Asked identity(const Door& door);
  Asked read_bits(const Door& door);
  void plan_read(Asked& asked, modbus::Table table, unsigned first, unsigned count) const;
  // asking_writes.cpp: registers.
  Asked write(const Door& door);
  void write_somewhere(Asked& asked);
  void mask(Asked& asked);
  void read_and_write(Asked& asked);
  void plan_read_and_write(Asked& asked, unsigned to, const Words& words, unsigned from,
                           unsigned reads) const;
  void opcode(Asked& asked);
  void single(Asked& asked, unsigned address, std::uint16_t value) const;
  void multiple(Asked& asked, unsigned first, unsigned count);
  void plan_write(Asked& asked, unsigned first, const Words& words) const;
  void add_writes(Asked& asked, unsigned first, const Words& words, bool together) const;
  void add_singles(Asked& asked, unsigned first, const Words& words) const;
  void ask_for_order(Asked& asked, unsigned first, unsigned count) const;
  // asking_others.cpp: what is written seldom, and stops.
  void coil(Asked& asked);
  void coils(Asked& asked);
  void plan_coils(Asked& asked, unsigned first, const Words& words) const;
  void own_function(Asked& asked);
  void file_record(Asked& asked);
  void diagnostics(Asked& asked);
  void add_whole(Asked& asked) const;
  Asked stop(const Door& door, bool are_alike);
  // asking_rare.cpp: what looks like something else, and what is as long as can be.
  [[nodiscard]] bool writes_one_by_one(const Door& door) const;
  void rare(Asked& asked);
  void stop_among_others(Asked& asked);
  void boot_among_others(Asked& asked);
  void listen_only(Asked& asked);
  void unknown_function(Asked& asked);
  void longest(Asked& asked);
  void longest_without_table(Asked& asked);
  // asking_broadcasts.cpp: what is for all.
  using Receivers = std::vector<const drive::Device*>;
  Asked broadcast(const Door& door);
  void pick_broadcast(Asked& asked);
  void pick_odd(Asked& asked);
  void pick_boot(Asked& asked);
  [[nodiscard]] Receivers listeners(std::size_t bus, bool autonics) const;
  Receivers add_forms(Asked& asked) const;
  [[nodiscard]] bool verifies(const Door& door) const;
  [[nodiscard]] static bool speak_alike(const Receivers& receivers);
  [[nodiscard]] const drive::WordOrder* order_seen(const Door& door) const;
  // asking_peculiar.cpp: the same, that some drives take for a stop or a value.
  void pick_peculiar(Asked& asked);
  void exchange_peculiar(Asked& asked, const Receivers& receivers) const;
  [[nodiscard]] const Peculiarity& peculiarity(const drive::Device& device) const;
  [[nodiscard]] bool hears_autonics(const Door& door) const;
  void exchange_for(Asked& asked, const Receivers& receivers) const;
  void add_piece(Asked& asked, PduBytes pdu) const;
  [[nodiscard]] const drive::Device& device_of(const Asked& asked) const {
    return plan_.settings.devices[*asked.door->device];
  }
  std::uint16_t next_value(const Asked& asked, unsigned address);

  /// Behind those of the registers, those of a device's coils and of what else it is told.
  static constexpr unsigned kCoil = kRegisters;
  static constexpr unsigned kRunOfCoils = kRegisters + 1;
  static constexpr unsigned kOwnCommand = kRegisters + 2;
  static constexpr unsigned kCounters = kRegisters + 3;

  const SoakPlan& plan_;
  Random& random_;
  std::vector<std::array<std::uint16_t, kCounters>> counters_;
  std::vector<std::vector<const Door*>> device_doors_;  // by listener
  std::vector<std::vector<const Door*>> broadcast_doors_;
  std::vector<std::vector<const Door*>> autonics_doors_;  // address 129
  Random forms_;     // what is asked seldom: with a chance of its own
  Random near_;      // likewise: reads that meet each other
  Random boots_;     // likewise: broadcasts after which drives boot
  Random rare_;      // likewise: what looks like something else
  Random peculiar_;  // likewise: broadcasts that drives take differently
  Random gateway_;   // likewise: what only the gateway answers
  Random ends_;      // likewise: what ends behind the last address
  bool goes_beyond_ = false;
  std::uint16_t broadcasts_ = 0;
  bool may_only_read_ = false;  // who asks at present
};

}  // namespace mbgate::soak

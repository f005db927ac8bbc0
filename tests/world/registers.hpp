// SPDX-License-Identifier: Apache-2.0
// What a drive holds, and what it held at any earlier instant, so that the judge knows which data a
// read may show. Some holding registers and all input registers change by themselves every
// millisecond; the others hold what was written, and so do coils; discrete inputs never change.
#pragma once

#include <unordered_map>

#include "world/frames.hpp"

namespace mbgate::world {

// The holding registers of every drive, and what its profile says of them.
inline constexpr unsigned kLiveFrom = 40;
inline constexpr unsigned kPairsFrom = 100;  ///< values of two registers
inline constexpr unsigned kPairsEnd = 140;
inline constexpr unsigned kOtherStop = 149;       ///< 4xxx stops, alone or together with the next
inline constexpr unsigned kStopRegister = 150;    ///< 5xxx stops
inline constexpr unsigned kSilentRegister = 151;  ///< 7xxx is carried out and never answered
inline constexpr unsigned kBroadcastRegister = 152;
inline constexpr unsigned kFailsafeRegister = 153;  ///< nobody but the gateway writes it
inline constexpr std::uint16_t kFailsafeWord = 0x5FFE;
inline constexpr unsigned kSlowFrom = 160;
inline constexpr unsigned kSlowEnd = 164;
inline constexpr unsigned kQuadsFrom = 164;  ///< values of four registers
inline constexpr unsigned kQuadsEnd = 176;
inline constexpr unsigned kGroupsFrom = 176;  ///< parameter groups of four registers each
inline constexpr unsigned kGroupsEnd = 188;
inline constexpr unsigned kGroup = 4;
inline constexpr unsigned kMotionFrom = 192;  ///< values of two whose write starts motion
inline constexpr unsigned kMotionEnd = 196;
inline constexpr unsigned kCommunicationRegister = 196;
inline constexpr unsigned kOrderRegister = 197;  ///< shows the drive's own word order
inline constexpr std::uint16_t kBigOrder = 5;
inline constexpr std::uint16_t kLittleOrder = 133;
inline constexpr unsigned kRegisters = 200;
inline constexpr unsigned kInputs = 100;  ///< input registers that a window shows
inline constexpr unsigned kCoils = 20000;
inline constexpr unsigned kStopCoil = kCoils - 1;
inline constexpr unsigned kTableEnd = 0x10000;

constexpr bool is_bits(Table table) {
  return table == Table::coils || table == Table::discrete_inputs;
}
constexpr bool is_live(Table table, unsigned address) {
  return table == Table::input_registers ||
         (table == Table::holding_registers && address >= kLiveFrom && address < kPairsFrom);
}
constexpr bool is_motion(unsigned address) {
  return address >= kMotionFrom && address < kMotionEnd;
}
/// How many holding registers the value has that the register belongs to; 1: it is no value.
constexpr unsigned value_size(unsigned address) {
  const bool is_pair = (address >= kPairsFrom && address < kPairsEnd) || is_motion(address);
  return is_pair ? 2U : address >= kQuadsFrom && address < kQuadsEnd ? 4U : 1U;
}
/// Its first register; the sizes divide the addresses where values begin.
constexpr unsigned value_begin(unsigned address) { return address - address % value_size(address); }
constexpr unsigned value_end(unsigned address) {
  return value_begin(address) + value_size(address);
}
/// Where a register's content stands in the other word order.
constexpr unsigned partner_of(unsigned address) {
  return value_begin(address) + value_end(address) - 1 - address;
}
/// Would a border in front of the register cut a value?
constexpr bool cuts_value(unsigned address) { return value_begin(address) != address; }

/// From `first` to `last`, both included.
struct Span {
  Instant first;
  Instant last;
};

class Registers {
 public:
  explicit Registers(std::uint64_t salt) : salt_(salt) {}

  [[nodiscard]] std::uint16_t read(Table table, unsigned address, Instant at) const;
  /// Of holding registers or coils; what lives by itself is not written.
  void write(Table table, unsigned address, std::uint16_t value, Instant at);
  /// Did registers from `first` on hold these words at one instant of the span?
  [[nodiscard]] bool held(Table table, unsigned first, std::span<const std::uint16_t> words,
                          Span span) const;

 private:
  struct Version {
    Instant since;
    std::uint16_t value;
  };
  using History = std::vector<Version>;
  [[nodiscard]] std::uint16_t salt(Table table, unsigned address) const;
  [[nodiscard]] const History* history(Table table, unsigned address) const;

  std::uint64_t salt_;
  std::unordered_map<unsigned, History> written_;  ///< by table and address
};

}  // namespace mbgate::world

// SPDX-License-Identifier: Apache-2.0
// What a soak device holds, and what it held at any earlier instant, so that the oracle knows which
// data a read may show. Holding registers 40 to 99 and all input registers change by themselves
// every millisecond; the others hold what was written, and so do coils; discrete inputs never
// change. Values of two registers are one thing in every respect.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "bus/instant.hpp"
#include "modbus/request.hpp"

namespace mbgate::soak {

using bus::Duration;
using bus::Instant;
using modbus::Table;

inline constexpr std::uint16_t kLiveFrom = 40;
inline constexpr std::uint16_t kPairsFrom = 100;
inline constexpr std::uint16_t kPairsEnd = 140;
inline constexpr std::uint16_t kStopRegister = 150;    ///< 06 of 5xxx stops
inline constexpr std::uint16_t kSilentRegister = 151;  ///< 06 of 7xxx is never answered
inline constexpr std::uint16_t kBroadcastRegister = 152;
inline constexpr std::uint16_t kFailsafeRegister = 153;  ///< and the next; written by nobody else
inline constexpr std::uint16_t kFailsafeStop = 0x5FFE;   ///< to the register of stops
inline constexpr std::uint16_t kSlowFrom = 160;          ///< and those behind it are slow
inline constexpr std::uint16_t kSlowEnd = 164;
inline constexpr std::uint16_t kQuadsFrom = 164;  ///< values of four registers
inline constexpr std::uint16_t kQuadsEnd = 176;
inline constexpr std::uint16_t kGroupsFrom = 176;  ///< parameter groups of four registers each
inline constexpr std::uint16_t kGroupsEnd = 188;
inline constexpr std::uint16_t kWriteOnlyFrom = 188;
inline constexpr std::uint16_t kMotionFrom = 192;  ///< values of two whose write starts motion
inline constexpr std::uint16_t kMotionEnd = 196;
inline constexpr std::uint16_t kCommunicationRegister = 196;
inline constexpr std::uint16_t kOrderRegister = 197;  ///< the drive's own word order; never written
inline constexpr std::uint16_t kBigOrder = 5;
inline constexpr std::uint16_t kLittleOrder = 133;
inline constexpr std::uint16_t kOpcodeRegister = 198;  ///< and a position in the two behind it
inline constexpr std::uint16_t kPositionOpcode = 0x98;
inline constexpr std::uint16_t kBroadcastRun = 201;
inline constexpr std::uint16_t kMostOfBroadcastRun = 3;
inline constexpr std::uint16_t kRegisters = 204;
inline constexpr std::uint16_t kValueOfSome = kRegisters;  ///< and the next; only for all at once
inline constexpr std::uint16_t kStopOfSome = 0x6000;       ///< to kBroadcastRegister
inline constexpr std::uint16_t kFirstRunOfCoils = 512;     ///< those below are written one by one
inline constexpr std::uint16_t kRunsOfCoilsEnd = 1024;
inline constexpr std::uint16_t kStopCoil = 1024;  ///< FF00 stops
inline constexpr std::uint16_t kBroadcastCoil = 1025;
inline constexpr std::uint16_t kBroadcastCoils = 1026;  ///< and 15 behind it
inline constexpr std::uint16_t kCoils = 1042;

/// Autonics AiC manual, section 2.13: where all of them listen, with the function OR 0x80.
inline constexpr std::uint8_t kAutonicsAddress = 129;
inline constexpr std::uint8_t kMostOfAutonics = 2;  ///< registers of a broadcast

/// Input registers of the status unit (src/gateway/status_unit.hpp): those of devices, each
/// with its bus, address, state and unanswered transmissions in a row.
inline constexpr std::uint16_t kDevicesAt = 10000;
inline constexpr std::uint16_t kDeviceSize = 32;
inline constexpr std::uint16_t kShownOfHealth = 4;
inline constexpr std::uint16_t kShownOffline = 3;

inline constexpr std::uint8_t kOwnFunction = 0x41;  ///< of the device's maker; it counts as a write
/// Of it and of other functions that name no table: these are repeated, refused with 01 or never
/// answered.
inline constexpr std::uint8_t kKnownCommand = 1;
inline constexpr std::uint8_t kRefusedCommand = 2;
inline constexpr std::uint8_t kUnheardCommand = 3;
inline constexpr std::uint16_t kMostIdentity = 8;  ///< input registers in the answer to 17, 43/14

/// Does the request read or write a register that is slow?
bool is_slow(modbus::Bytes request);

constexpr bool is_motion(Table table, unsigned address) {
  return table == Table::holding_registers && address >= kMotionFrom && address < kMotionEnd;
}
constexpr bool is_in_pair(Table table, unsigned address) {
  return is_motion(table, address) ||
         (table == Table::holding_registers && address >= kPairsFrom && address < kPairsEnd);
}
constexpr bool is_in_quad(Table table, unsigned address) {
  return table == Table::holding_registers && address >= kQuadsFrom && address < kQuadsEnd;
}
constexpr bool is_in_value(Table table, unsigned address) {
  return is_in_pair(table, address) || is_in_quad(table, address);
}
constexpr bool is_live(Table table, unsigned address) {
  return table == Table::input_registers ||
         (table == Table::holding_registers && address >= kLiveFrom && address < kPairsFrom);
}
/// The first register of the pair that the register belongs to.
constexpr std::uint16_t pair_of(unsigned address) {
  return static_cast<std::uint16_t>(address & ~1U);
}
/// The first register of the value that the register belongs to, and the one behind its last.
constexpr unsigned value_begin(unsigned address) {
  return is_in_quad(Table::holding_registers, address) ? address & ~3U : address & ~1U;
}
constexpr unsigned value_end(unsigned address) {
  return value_begin(address) + (is_in_quad(Table::holding_registers, address) ? 4U : 2U);
}
/// Where its content stands in the other word order.
constexpr std::uint16_t partner_of(unsigned address) {
  return static_cast<std::uint16_t>(value_begin(address) + value_end(address) - 1 - address);
}
/// Would a border between two registers cut a value?
constexpr bool cuts_value(unsigned border) {
  return is_in_value(Table::holding_registers, border) && value_begin(border) != border;
}

/// From `first` to `last`, both included.
struct Span {
  Instant first;
  Instant last;
};

class Registers {
 public:
  explicit Registers(std::uint64_t salt);

  [[nodiscard]] std::uint16_t read(Table table, unsigned address, Instant at) const;
  void write(unsigned address, std::uint16_t value, Instant at);
  /// Both registers of a value at once.
  void write_pair(unsigned first, std::uint32_t words, Instant at);
  void write_coil(unsigned address, bool value, Instant at);
  /// Did the register hold the value at some instant of the span?
  [[nodiscard]] bool held(Table table, unsigned address, std::uint16_t value, Span span) const;
  /// The same, of the low byte alone.
  [[nodiscard]] bool low_held(Table table, unsigned address, std::uint8_t value, Span span) const;
  /// Did the value hold both words at one instant? The lower address is in the high half.
  [[nodiscard]] bool pair_held(unsigned first, std::uint32_t words, Span span) const;

 private:
  struct Version {
    Instant since;
    std::uint32_t words;
  };
  using History = std::vector<Version>;
  [[nodiscard]] const History& history(unsigned address) const {
    return histories_[is_in_pair(Table::holding_registers, address) ? pair_of(address) : address];
  }
  [[nodiscard]] const History* written_bit(Table table, unsigned address) const;
  [[nodiscard]] std::uint16_t salt(Table table, unsigned address) const;
  template <typename Fits>
  static bool any(const History& history, Span span, Fits fits);

  std::uint64_t salt_;
  std::array<History, kRegisters> histories_;
  std::unordered_map<unsigned, History> coils_;  ///< that were written
};

}  // namespace mbgate::soak

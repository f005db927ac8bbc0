// SPDX-License-Identifier: Apache-2.0
// What a soak device holds, and what it held at any earlier instant, so that the oracle knows which
// data a read may show. Holding registers 0 to 39 and 160 to 163 hold what was written, 40 to 99
// change by themselves every millisecond, 100 to 139 are 20 values of two registers each, which are
// one thing in every respect; input registers change by themselves, coils hold what was written,
// and discrete inputs never change.
#pragma once

#include <array>
#include <cstdint>
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
inline constexpr std::uint16_t kRegisters = 164;
inline constexpr std::uint16_t kCoils = 1024;
inline constexpr std::uint16_t kFirstRunOfCoils = 512;  ///< those below are written one by one

inline constexpr std::uint8_t kOwnFunction = 0x41;  ///< of the device's maker; it counts as a write
inline constexpr std::uint8_t kKnownCommand = 1;    ///< of it; others are refused with 01
inline constexpr std::uint16_t kMostIdentity = 8;   ///< input registers in the answer to 17, 43/14

/// Does the request read or write a register that is slow?
bool is_slow(modbus::Bytes request);

constexpr bool is_in_pair(Table table, unsigned address) {
  return table == Table::holding_registers && address >= kPairsFrom && address < kPairsEnd;
}
constexpr bool is_live(Table table, unsigned address) {
  return table == Table::input_registers ||
         (table == Table::holding_registers && address >= kLiveFrom && address < kPairsFrom);
}
/// The first register of the pair that the register belongs to.
constexpr std::uint16_t pair_of(unsigned address) {
  return static_cast<std::uint16_t>(address & ~1U);
}
constexpr std::uint16_t partner_of(unsigned address) {
  return static_cast<std::uint16_t>(address ^ 1U);
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

// SPDX-License-Identifier: Apache-2.0
// The gateway's knowledge of a kind of drive: pure rules, with protocol addresses. Names, and the
// lines of the manual that the rules come from, are in the profile's file (conf/profiles);
// config::ProfileFile keeps them.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drive/values.hpp"
#include "modbus/frames.hpp"
#include "modbus/request.hpp"
#include "modbus/rtu_timing.hpp"

namespace mbgate::drive {

// A write with a special meaning for a drive: table, address, and which values.

struct WriteMatch {
  modbus::Table table = modbus::Table::holding_registers;
  std::uint16_t address = 0;
  std::uint16_t mask = 0xFFFF;
  std::uint16_t value = 0;  ///< of the masked bits; of a coil 0000 or FF00
  bool other = false;       ///< any masked bits but `value`
  /// How many registers right behind it may be written together with it: the parameters of an
  /// opcode.
  std::uint16_t parameters = 0;

  [[nodiscard]] bool fits(std::uint16_t written) const {
    return ((written & mask) == value) != other;
  }
  friend bool operator==(const WriteMatch&, const WriteMatch&) = default;
};

/// Does the request (05, 06, 15, 16, 23) write this, alone or among others?
bool writes(const modbus::Request& request, const WriteMatch& match);

using modbus::Duration;

/// The most registers or coils of one request.
struct Limits {
  /// By modbus::Table. Application Protocol V1.1b3, 6.1 to 6.4.
  std::array<std::uint16_t, 4> read{2000, 2000, 125, 125};
  std::uint16_t write_coils = 1968;     ///< 6.11
  std::uint16_t write_registers = 123;  ///< 6.12
  [[nodiscard]] std::uint16_t read_from(modbus::Table table) const {
    return read[static_cast<std::size_t>(table)];
  }
  [[nodiscard]] std::uint16_t written_to(modbus::Table table) const {
    return table == modbus::Table::coils ? write_coils : write_registers;
  }
  friend bool operator==(const Limits&, const Limits&) = default;
};

/// The form in which drives receive broadcasts. By default that of the standard: address 0 (Serial
/// Line V1.02, 2.2). The Autonics AiC has address 129 and function OR 0x80 (its manual, section
/// 2.13).
struct BroadcastForm {
  std::uint8_t address = 0;
  std::uint8_t function_or = 0;  ///< added to the function code
  [[nodiscard]] bool is_standard() const { return *this == BroadcastForm{}; }
  friend bool operator==(const BroadcastForm&, const BroadcastForm&) = default;
};

struct Broadcast {
  std::optional<BroadcastForm> form = BroadcastForm{};  ///< none: the manual states none
  std::optional<std::uint16_t> most_registers;          ///< of function 16
  std::optional<RangeList> allowed;                     ///< none: everything
  bool only = true;  ///< a drive with a form of its own hears nothing at address 0
  [[nodiscard]] bool has_own_form() const { return form && !form->is_standard(); }
  /// Does the manual say that broadcasts in this form reach the drive?
  [[nodiscard]] bool hears(BroadcastForm sent) const {
    return form && (*form == sent || (sent.is_standard() && !only));
  }
  friend bool operator==(const Broadcast&, const Broadcast&) = default;
};

/// Registers whose reads and writes take longer than others.
struct SlowRegisters {
  TableRange range;
  Duration response_timeout;
  friend bool operator==(const SlowRegisters&, const SlowRegisters&) = default;
};

/// A write that is carried out and never answered.
struct UnansweredWrite {
  WriteMatch match;
  Duration after;  ///< for this long the device does not listen
  friend bool operator==(const UnansweredWrite&, const UnansweredWrite&) = default;
};

/// A write of certain values that restores, initialises or rearranges a drive, or takes it off the
/// line. Of one register or coil, or of a value of 32 bits.
struct GuardedWrite {
  TableRange range;
  std::uint32_t mask = 0xFFFFFFFF;
  std::uint32_t value = 0;  ///< of the masked bits; of a coil 0000 or FF00
  bool other = false;       ///< any masked bits but `value`

  [[nodiscard]] bool fits(std::uint32_t written) const {
    return ((written & mask) == value) != other;
  }
  friend bool operator==(const GuardedWrite&, const GuardedWrite&) = default;
};

/// May the request write what is guarded? Where it cannot be known what the register or value will
/// hold (function 22, half a value, no word order), it may. `order`: of the values in the request.
[[nodiscard]] bool may_write(const modbus::Request& request, const GuardedWrite& guarded,
                             std::optional<WordOrder> order);

/// The register in which a drive shows its word order, if that can be set, with the values for
/// each.
struct WordOrderRegister {
  std::uint16_t address;
  std::vector<std::uint16_t> big;
  std::vector<std::uint16_t> little;
  friend bool operator==(const WordOrderRegister&, const WordOrderRegister&) = default;
};

/// Opcodes with a position in two 16-bit parameter registers whose order no manual states.
struct PositionOpcodes {
  std::uint16_t address;  ///< of the opcode
  std::vector<std::uint16_t> opcodes;
  std::uint16_t position;  ///< the first of the two registers
  friend bool operator==(const PositionOpcodes&, const PositionOpcodes&) = default;
};

struct Profile {
  std::string name = "generic";
  std::uint8_t first_address = 1;  ///< on a serial line
  std::uint8_t last_address = modbus::kMaxDeviceAddress;
  std::bitset<128> functions = std::bitset<128>().set().reset(0);
  std::optional<WordOrder> word_order;  ///< fixed by the maker
  bool word_order_settable = false;
  Limits limits;
  bool input_as_holding = false;               ///< function 04 reads the same registers as 03
  std::optional<std::uint8_t> write_function;  ///< 6 or 16: the one that the maker prefers
  std::optional<Duration> response_timeout;    ///< none: that of the bus
  Duration response_wait{0};
  Broadcast broadcast;
  ValueSet values;
  RangeList map;     ///< which registers there are; none: not known
  RangeList groups;  ///< parameter groups: no request crosses the border of one
  RangeList read_only;
  RangeList write_only;
  RangeList communication;
  std::vector<GuardedWrite> guarded;
  std::optional<WordOrderRegister> word_order_register;
  std::optional<PositionOpcodes> position_opcodes;
  std::vector<SlowRegisters> slow;
  std::vector<UnansweredWrite> unanswered;
  std::vector<WriteMatch> stops;
  /// Exceptions by which the drive says that it carries a write out, by their code.
  std::bitset<256> acceptances;

  /// The table under which the profile describes the registers of this one.
  [[nodiscard]] modbus::Table described_in(modbus::Table table) const {
    return input_as_holding && table == modbus::Table::input_registers
               ? modbus::Table::holding_registers
               : table;
  }
  /// Where a request that begins at `address` must end at the latest: at the end of its
  /// parameter group, or before the next one. 65536 if there is none.
  [[nodiscard]] std::uint32_t group_end(modbus::Table table, std::uint32_t address) const;
  /// Does a stop, a write that is never answered, a guarded register, an opcode or its position
  /// parameter lie in the range, or a communication register beside another one? None of these may
  /// be moved or exchanged as part of a value.
  [[nodiscard]] bool is_special(const TableRange& range) const;
  friend bool operator==(const Profile&, const Profile&) = default;
};

}  // namespace mbgate::drive

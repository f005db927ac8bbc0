// SPDX-License-Identifier: Apache-2.0
// The access rules, in their order in the configuration. The first rule that matches a request
// decides; a request that no rule matches is denied, unless there are no rules at all. Pure data,
// and one function that decides; gateway/access collects the facts about a request.
#pragma once

#include <bitset>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drive/device.hpp"
#include "routing/client_address.hpp"
#include "routing/route.hpp"

namespace mbgate::routing {

/// What of a write stops its device.
enum class StopIn : std::uint8_t {
  none,
  some,  ///< something of it stops the device, or may do so
  all,   ///< each of its registers gets a value that stops the device
};

/// What is read or written of one device by one transaction.
struct TouchedRegisters {
  std::optional<std::size_t> number{};        ///< of the device; none: none is configured there
  const drive::Device* device = nullptr;      ///< the same
  std::optional<modbus::TableRange> range{};  ///< of the device; none: its function names no table
  StopIn stop = StopIn::none;
  bool reconfigures = false;  ///< it is a write that the profile of the device guards
};

// Registers and coils that an access rule names: by their addresses in the device, or by what the
// device's profile says of them.

/// Both ends belong to it.
struct RegisterSpan {
  modbus::Table table = modbus::Table::holding_registers;
  std::uint16_t first = 0;
  std::uint16_t last = 0xFFFF;
  friend bool operator==(const RegisterSpan&, const RegisterSpan&) = default;
};

struct RegisterSet {
  std::vector<RegisterSpan> spans{};
  /// Values whose write starts motion, opcodes with their position, and the registers of stops:
  /// what stops a drive with one value mostly starts it with another.
  bool motion_commands = false;
  /// With them, if the write reconfigures its device, the registers whose values decide that.
  bool communication_registers = false;
  bool values = false;  ///< all values of 32 and 64 bits
  /// No registers: writes of a stop. access_rules knows them by what they write.
  bool stops = false;

  [[nodiscard]] bool empty() const {
    return spans.empty() && !motion_commands && !communication_registers && !values && !stops;
  }
  /// Are all registers of the range, which must be known, in it? Where a drive reads the same
  /// registers with 03 and 04, both tables are one.
  [[nodiscard]] bool covers(const TouchedRegisters& touched) const;
  /// Is any of them in it?
  [[nodiscard]] bool touches(const TouchedRegisters& touched) const;
  /// Is everything of the other one in it, whatever the device?
  [[nodiscard]] bool contains(const RegisterSet& other) const;
  friend bool operator==(const RegisterSet&, const RegisterSet&) = default;
};

using UnitSet = std::bitset<256>;
using FunctionSet = std::bitset<128>;

/// `[[group]]`. A client belongs to it by its address and its role, as far as these are named.
struct ClientGroup {
  std::string name;
  NetworkList addresses;           ///< none: any
  std::vector<std::string> roles;  ///< none: any; "" is the NULL role
  friend bool operator==(const ClientGroup&, const ClientGroup&) = default;
};

/// Which half of the requests a rule is about. One that reads and writes (23) has both.
enum class RuleAccess : std::uint8_t { both, read, write };

/// `[[rule]]`: all of it must fit. What is empty fits everything.
struct AccessRule {
  std::string name{};
  std::string place{};  ///< "mbgate.toml:12"
  bool permits = true;
  std::vector<ClientGroup> clients{};
  std::vector<std::string> roles{};
  bool any_role = false;  ///< clients with a role match, though the rule names none
  std::vector<ListenerId> listeners{};
  std::optional<UnitSet> units{};
  std::vector<std::size_t> devices{};  ///< numbers in the settings
  std::optional<FunctionSet> functions{};
  RuleAccess access = RuleAccess::both;
  RegisterSet registers{};
  unsigned per_second = 0;  ///< requests of a client address; 0: any number

  /// Its name in quotes, if it has one, and its place.
  [[nodiscard]] std::string title() const;
  friend bool operator==(const AccessRule&, const AccessRule&) = default;
};

/// One half of a request, and who asks. What is not known yet is empty.
struct AccessQuestion {
  const ClientAddress& address;
  const ClientRole* role;  ///< nullptr: not known yet
  ListenerId listener;
  std::optional<std::uint8_t> unit{};
  /// Units that lead to what the request reaches: `unit` alone, or those that a broadcast is for
  /// too.
  UnitSet reached{};
  std::optional<std::uint8_t> function{};
  std::optional<bool> is_read{};
  std::optional<std::span<const TouchedRegisters>> touched{};
};

struct AccessDecision {
  bool permitted = true;
  const AccessRule* rule = nullptr;  ///< that has decided; nullptr: none has matched
};

/// A rule that permits matches only if it fits all that is touched; one that denies, if it fits any
/// of it. As long as something is not known, a rule that may match permits, and does not deny: so
/// it is asked whether anything can be permitted.
[[nodiscard]] AccessDecision decide(std::span<const AccessRule> rules,
                                    const AccessQuestion& question);

/// Does every request that matches `later` match `earlier` too? A false answer may be wrong, a true
/// one never is.
[[nodiscard]] bool hides(const AccessRule& earlier, const AccessRule& later);

}  // namespace mbgate::routing

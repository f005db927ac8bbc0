// SPDX-License-Identifier: Apache-2.0
// The access rules of one seed, and what they deny, worked out from the words of the documentation:
// the first rule that fits decides, what none fits is denied, and a request that reads and writes
// asks twice.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "routing/client_role.hpp"
#include "soak/from_world.hpp"
#include "soak/registers.hpp"

namespace mbgate::soak {

struct Asked;
struct SoakPlan;

/// Who is in it comes from one of these hosts, if any are named, and has one of these roles, if any
/// are named.
struct SpokenGroup {
  std::vector<unsigned> hosts{};
  std::vector<std::string> roles{};
};

/// Both ends belong to it.
struct SpokenSpan {
  Table table = Table::holding_registers;
  unsigned first = 0;
  unsigned last = 0xFFFF;
};

struct SpokenRegisters {
  std::vector<SpokenSpan> spans{};
  bool motion = false;
  bool communication = false;
  bool values = false;
  bool stops = false;

  [[nodiscard]] bool are_any() const {
    return !spans.empty() || motion || communication || values || stops;
  }
};

/// What is empty fits everything.
struct SpokenRule {
  bool permits = true;
  bool reads = true;   ///< it is about requests that read,
  bool writes = true;  ///< or about those that write
  std::vector<SpokenGroup> groups{};
  std::vector<std::string> roles{};
  bool any_role = false;
  std::vector<std::size_t> listeners{};
  std::vector<std::size_t> devices{};
  std::vector<std::uint8_t> units{};
  std::vector<std::uint8_t> functions{};
  SpokenRegisters registers{};
  unsigned rate = 0;  ///< requests a second of one host that it permits; 0: any number
};

/// Some plants have rules. Where devices are written to when those who may write are gone, only
/// such as say who may write.
void draw_access(SoakPlan& plan, std::uint64_t seed);
/// What only few rules name: devices, registers, listeners, groups and roles. After the clients.
void draw_close_access(SoakPlan& plan, std::uint64_t seed);
/// Drives that show the same registers in two tables, and a rule that denies one of these.
void draw_tables(SoakPlan& plan, std::uint64_t seed);
/// Of the devices that one may ask.
std::vector<std::uint8_t> draw_units(const SoakPlan& plan, Random& random);
std::vector<unsigned> draw_hosts(Random& random, unsigned permille);
/// The rules of the plan, in the words of its settings.
void write_rules(SoakPlan& plan);
/// Is anything written to a device when those who may write are gone?
bool is_guarded(const SoakPlan& plan);
/// What it names is there: a list of which nothing is there is not written down.
[[nodiscard]] bool is_written(const SoakPlan& plan, const SpokenRule& rule);
/// May they permit anything to whoever comes from this host? What the role in a certificate would
/// do is not asked yet.
[[nodiscard]] bool lets_in_by_rules(const SoakPlan& plan, std::size_t listener, unsigned host,
                                    const routing::ClientRole& role);
/// May they permit whoever comes from this host, and has no role, any write to the device?
[[nodiscard]] bool lets_write_by_rules(const SoakPlan& plan, std::size_t listener, unsigned host,
                                       std::size_t device);
/// 01 if the rules deny it to its client on this listener, whatever else would be said of it; else
/// the rules whose rate it counts for.
void deny_by_rules(const SoakPlan& plan, std::size_t listener, Asked& asked);

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
// Findings about a serial port from the facts that the system shows. The facts are passed in; this
// code does not examine the port.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ctl/doctor/finding.hpp"
#include "ctl/serial/serial_port.hpp"

namespace mbgate::ctl {

struct PortFacts {
  int error = 0;                       ///< of stat(); 0: it is there
  bool is_character_device = false;    ///< a terminal is one
  std::vector<std::string> names{};    ///< all below /dev/serial/by-id
  std::vector<std::string> leading{};  ///< those that lead to this port
  bool is_lasting = false;             ///< the path is itself one of the names
};
Finding port_finding(const std::string& device, const PortFacts& facts);

struct PermissionFacts {
  int error = 0;  ///< what opening it would fail with; 0: we may
  std::string owner;
  std::string group;
  unsigned mode = 0;            ///< 0660
  std::string user;             ///< who we are
  bool is_member = false;       ///< this process, of the group
  bool becomes_member = false;  ///< the user, with the next login
};
Finding permission_finding(const std::string& device, const PermissionFacts& facts);

struct Holder {
  int process;
  std::string name;
};
/// Of a port that another program holds; `holders` are those that could be seen, maybe none.
Finding held_finding(const std::string& device, const std::vector<Holder>& holders);
/// Of a port that we hold; `others` have it open too, without a lock.
Finding free_finding(const std::string& device, const std::vector<Holder>& others);

struct LatencyFacts {
  std::string real_path;  ///< "/dev/ttyUSB0", for every name that leads there
  /// How long an FTDI chip collects bytes, in ms. None: it is no FTDI, or hides it.
  std::optional<unsigned> timer{};
  std::optional<bool> low_latency{};  ///< what the configuration says
};
Finding latency_finding(const LatencyFacts& facts);
/// By how much answers may come sooner to a gateway than to us: it shortens the timer.
std::chrono::milliseconds avoidable_delay(const LatencyFacts& facts);

/// `refusal` is why the port cannot have the mode, none if it has it.
Finding settings_finding(const LineMode& mode, const std::optional<std::string>& refusal);

}  // namespace mbgate::ctl

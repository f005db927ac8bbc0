// SPDX-License-Identifier: Apache-2.0
// The doctor's finding at one step, as a line for people or as JSON.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ctl/doctor/trial.hpp"
#include "ctl/serial/serial_port.hpp"
#include "modbus/bytes.hpp"

namespace mbgate::ctl {

enum class Judgement : std::uint8_t {
  ok,
  fault,
  unknown  ///< it cannot be known, or several causes would look like this
};

struct Finding {
  Judgement verdict = Judgement::ok;
  std::string step;      ///< "port", "answers of unit 3"
  std::string seen;      ///< how it is known
  std::string advice{};  ///< what to do; may be empty
  friend bool operator==(const Finding&, const Finding&) = default;
};

/// "fault    latency: its timer is 16 ms; set low_latency = true".
std::string finding_line(const Finding& finding);

/// {"device":"/dev/ttyUSB0","findings":[{"verdict":"ok","step":"port","seen":"..."}]}, with
/// "advice" where there is one, and "error" if the examination ended early.
std::string findings_json(const std::string& device, const std::vector<Finding>& findings,
                          const std::optional<std::string>& error);

/// "4.1 ms": rounded to a tenth.
std::string tenths_text(std::chrono::nanoseconds time);

// Findings about a serial port from the facts that the system shows. The facts are passed in; this
// code does not examine the port.

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
Finding settings_finding(const LineMode& mode, const std::optional<std::string>& refusal,
                         bool is_pseudo_terminal);

// Looks at a serial port from outside, as the system shows it: nothing is opened.

PortFacts look_at_port(const std::string& device);
PermissionFacts look_at_permission(const std::string& device);
/// Who has locked the port: that one process, which anybody may see. Else those of find_holders().
std::vector<Holder> find_lock_holders(const std::string& device);
/// The other processes that have the port open, as far as we may see them: without root only those
/// of our own user.
std::vector<Holder> find_holders(const std::string& device);
/// `low_latency` of the facts is not set.
LatencyFacts look_at_latency(const std::string& device);
/// What is at the other end of a pseudo-terminal is a program, which has both ends open.
[[nodiscard]] bool is_pseudo_terminal(const std::string& device);

/// What was heard on an idle line.
struct IdleLine {
  std::vector<std::uint8_t> heard{};  ///< the first bytes; of a line full of noise not all
  std::size_t bytes = 0;              ///< all that came
  std::chrono::nanoseconds time{0};   ///< how long it was listened to
};

Finding idle_finding(const IdleLine& line, const LineMode& mode);

/// Are there frames of another client?
[[nodiscard]] bool is_of_another_client(const IdleLine& line);
/// May there be some, at whatever rate and parity? Whoever sends there now damages them.
[[nodiscard]] bool may_be_of_another_client(const IdleLine& line);

/// What to do where another client is heard.
inline constexpr const char* kOneClient =
    "an RS-485 line has one client: let the other one (a gateway, a PLC, a tool) connect to the "
    "gateway instead";

// Findings about the line from the answers of all units together: whether it has an echo, and
// whether two devices have one address.

/// Of what came before anything was sent, or else between two requests; nothing where that is of no
/// importance.
std::optional<Finding> foreign_finding(const Unasked& before, const std::vector<UnitTrials>& units);

/// Each of the units was asked at least once.
Finding echo_finding(const LinePlan& plan, const std::vector<UnitTrials>& units);

/// Nothing is claimed that another cause could explain as well.
Finding addresses_finding(const std::vector<UnitTrials>& units);

/// How well and how soon each unit answers, in their order; each was asked at least once. Where
/// causes look alike, all of them are named.
std::vector<Finding> answer_findings(const LinePlan& plan, const std::vector<UnitTrials>& units);

}  // namespace mbgate::ctl

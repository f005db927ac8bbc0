// SPDX-License-Identifier: Apache-2.0
#include "ctl/doctor/examination_shell.hpp"

#include <algorithm>
#include <utility>

#include "ctl/doctor/answer_findings.hpp"
#include "ctl/doctor/idle_line.hpp"
#include "ctl/doctor/line_findings.hpp"
#include "ctl/doctor/port_facts_shell.hpp"
#include "ctl/doctor/tally.hpp"
#include "ctl/request/interruption.hpp"
#include "ctl/serial/serial_client.hpp"

namespace mbgate::ctl {
namespace {

using std::chrono::nanoseconds;
using std::chrono::steady_clock;

constexpr const char* kEndedBySignal = "interrupted";
/// A signal waits no longer than this while the idle line is listened to.
constexpr std::chrono::milliseconds kListenedAtOnce{100};
/// Of the idle line: enough to see what it looks like.
constexpr std::size_t kMostKept = 4096;
/// Answers later than the gateway waits for are still heard: twice its timeout, and at least this.
constexpr std::chrono::milliseconds kLeastPatience{1000};
/// The answer of a second device begins by then.
constexpr std::chrono::milliseconds kSecondAnswer{100};
/// A serial device server on a wireless network may pause so long within a frame.
constexpr std::chrono::milliseconds kRestOfFrame{300};

/// Port and permission; false if there is no use in opening it.
bool examine_from_outside(const std::string& device, const ReportFinding& report) {
  const auto port = port_finding(device, look_at_port(device));
  report(port);
  if (port.verdict != Judgement::ok) {
    return false;
  }
  const auto permission = permission_finding(device, look_at_permission(device));
  report(permission);
  return permission.verdict == Judgement::ok;
}

/// The port, with its mode set; nothing if it cannot be had.
std::optional<SerialClient> take_port(const LinePlan& plan, const ReportFinding& report) {
  auto client = SerialClient::open(plan.device);
  if (!client) {
    report(is_held(plan.device, client.error())
               ? held_finding(plan.device, find_lock_holders(plan.device))
               : Finding{Judgement::fault, "port", client.error()});
    return std::nullopt;
  }
  report(free_finding(plan.device, is_pseudo_terminal(plan.device) ? std::vector<Holder>()
                                                                   : find_holders(plan.device)));
  auto latency = look_at_latency(plan.device);
  latency.low_latency = plan.low_latency;
  report(latency_finding(latency));
  const auto refusal = client->set_mode(plan.mode);
  report(settings_finding(plan.mode, refusal));
  return refusal ? std::nullopt : std::optional(*std::move(client));
}

class Examination {
 public:
  Examination(const LinePlan& plan, const DoctorCommand& command, SerialClient client)
      : plan_(plan), command_(command), client_(std::move(client)) {}

  /// What ended it early, if anything did.
  std::optional<std::string> listen(IdleLine& idle) {
    if (interruption_.wait_until(client_.ready_at())) {
      return kEndedBySignal;
    }
    const auto begin = steady_clock::now();
    while (idle.time < command_.listen) {
      const auto pieces =
          client_.overhear(std::min<nanoseconds>(kListenedAtOnce, command_.listen - idle.time));
      if (!pieces) {
        return pieces.error();
      }
      keep(*pieces, idle);
      idle.time = steady_clock::now() - begin;
      if (interruption_.wait_until(begin)) {
        return kEndedBySignal;
      }
    }
    idle.time = command_.listen;
    return std::nullopt;
  }

  /// Asks all units in turn; those that were asked at all are in `units`.
  std::optional<std::string> ask(std::vector<UnitTrials>& units) {
    for (const auto& unit : plan_.units) {
      UnitTrials asked{unit};
      auto error = ask_unit(asked);
      if (!asked.trials.empty()) {
        units.push_back(std::move(asked));
      }
      if (error) {
        return error;
      }
    }
    return std::nullopt;
  }

 private:
  static void keep(const std::vector<Piece>& pieces, IdleLine& idle) {
    for (const auto& piece : pieces) {
      idle.bytes += piece.bytes.size();
      if (idle.heard.size() < kMostKept) {
        idle.heard.insert(idle.heard.end(), piece.bytes.begin(), piece.bytes.end());
      }
    }
  }

  std::optional<std::string> ask_unit(UnitTrials& asked) {
    const auto& unit = asked.unit;
    const SentRead sent(unit.address,
                        {modbus::Table::holding_registers, command_.holding_register, 1});
    const ListenTimes times{std::max<nanoseconds>(2 * unit.timeout, kLeastPatience), kSecondAnswer,
                            kRestOfFrame};
    while (asked.trials.size() < command_.requests && !is_given_up(asked.trials)) {
      if (interruption_.wait_until(client_.ready_at() + unit.pause)) {
        return kEndedBySignal;
      }
      const auto pieces = client_.ask_all(sent, times);
      if (!pieces) {
        return pieces.error();
      }
      asked.trials.push_back(understand(sent, *pieces));
    }
    return std::nullopt;
  }

  const LinePlan& plan_;
  const DoctorCommand& command_;
  Interruption interruption_;
  SerialClient client_;
};

std::optional<std::string> ask_and_report(Examination& examination, const LinePlan& plan,
                                          const ReportFinding& report) {
  std::vector<UnitTrials> units;
  auto error = examination.ask(units);
  if (units.empty()) {
    return error;
  }
  report(echo_finding(plan, units));
  for (const auto& finding : answer_findings(plan, units)) {
    report(finding);
  }
  report(addresses_finding(units));
  return error;
}

}  // namespace

std::optional<std::string> examine(const LinePlan& plan, const DoctorCommand& command,
                                   const ReportFinding& report) {
  if (!examine_from_outside(plan.device, report)) {
    return std::nullopt;
  }
  auto client = take_port(plan, report);
  if (!client) {
    return std::nullopt;
  }
  Examination examination(plan, command, *std::move(client));
  IdleLine idle;
  if (auto error = examination.listen(idle)) {
    return error;
  }
  report(idle_finding(idle, plan.mode));
  if (is_of_another_client(idle)) {
    report({Judgement::unknown, "answers",
            "nobody was asked: that would damage the frames of the other client"});
    return std::nullopt;
  }
  if (plan.nobody) {
    report({Judgement::unknown, "answers", "nobody was asked: " + *plan.nobody});
    return std::nullopt;
  }
  return ask_and_report(examination, plan, report);
}

}  // namespace mbgate::ctl

// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cerrno>
#include <fmt/core.h>
#include <functional>
#include <ostream>
#include <utility>

#include "base/text.hpp"
#include "config/toml/toml_value.hpp"
#include "ctl/doctor/findings.hpp"
#include "ctl/doctor/questions_shell.hpp"
#include "ctl/request/carry_out.hpp"
#include "ctl/request/repetition.hpp"

namespace mbgate::ctl {
namespace {

using ReportFinding = std::function<void(const Finding&)>;

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
std::optional<SerialClient> take_port(LinePlan& plan, const ReportFinding& report) {
  auto client = SerialClient::open(plan.device);
  if (!client) {
    report(client.error() == EBUSY
               ? held_finding(plan.device, find_lock_holders(plan.device))
               : Finding{Judgement::fault, "port", port_failure(plan.device, client.error())});
    return std::nullopt;
  }
  const bool is_pty = is_pseudo_terminal(plan.device);
  const auto holders = is_pty ? std::vector<Holder>() : find_holders(plan.device);
  report(free_finding(plan.device, holders));
  if (!holders.empty()) {
    return std::nullopt;  // not even its mode is ours to set
  }
  auto latency = look_at_latency(plan.device);
  latency.low_latency = plan.low_latency;
  plan.adapter_delay = avoidable_delay(latency);
  report(latency_finding(latency));
  const auto refusal = client->set_mode(plan.mode);
  report(settings_finding(plan.mode, refusal, is_pty));
  return refusal ? std::nullopt : std::optional(*std::move(client));
}

std::optional<std::string> ask_and_report(Questions& questions, const LinePlan& plan,
                                          const ReportFinding& report) {
  Answers answers;
  auto error = questions.ask(answers);
  if (const auto foreign = foreign_finding(answers.before, answers.units)) {
    report(*foreign);
  }
  const auto& units = answers.units;
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

/// Why nobody is asked, if so.
std::optional<std::string> reason_to_ask_nobody(const IdleLine& idle, const LinePlan& plan) {
  if (is_of_another_client(idle)) {
    return "requests would damage the frames of the other client";
  }
  if (may_be_of_another_client(idle)) {
    return "these bytes may be from another client, and requests would damage its frames";
  }
  return plan.nobody;
}

/// Step by step; ends where going on makes no sense, and hands out each finding as it is made.
/// Returns why it ended early, if a signal or the port ended it.
std::optional<std::string> examine(const LinePlan& plan, const DoctorCommand& command,
                                   const ReportFinding& report) {
  if (!examine_from_outside(plan.device, report)) {
    return std::nullopt;
  }
  // Before the port is taken: whatever ends it gives the port its settings back.
  const Interruption interruption;
  LinePlan line = plan;
  auto client = take_port(line, report);
  if (!client) {
    return std::nullopt;
  }
  Questions questions(line, command, *std::move(client), interruption);
  IdleLine idle;
  if (auto error = questions.listen(idle)) {
    return error;
  }
  report(idle_finding(idle, line.mode));
  if (const auto reason = reason_to_ask_nobody(idle, line)) {
    report({Judgement::unknown, "answers", "no device was asked: " + *reason});
    return std::nullopt;
  }
  return ask_and_report(questions, line, report);
}

std::string announcement(const LinePlan& plan, const DoctorCommand& command) {
  std::string text = fmt::format("examining {} at {}: listens for {}", plan.device,
                                 mode_text(plan.mode), config::to_text(command.listen));
  if (!plan.nobody) {
    text +=
        fmt::format(", then reads holding register {} {}{}", command.holding_register,
                    counted(command.requests, "time"),
                    plan.units.size() == 1 ? " of " + unit_text(plan.units.front())
                                           : " of each of " + counted(plan.units.size(), "unit"));
  }
  return text + "; nothing is written";
}

int examine_and_print(const LinePlan& plan, const DoctorCommand& command, std::ostream& out,
                      std::ostream& errors) {
  if (!command.json) {
    errors << announcement(plan, command) << '\n' << std::flush;
  }
  std::vector<Finding> findings;
  const auto error = examine(plan, command, [&](const Finding& finding) {
    findings.push_back(finding);
    if (!command.json) {
      out << finding_line(finding) << '\n' << std::flush;
    }
  });
  if (command.json) {
    out << findings_json(plan.device, findings, error) << '\n';
  } else if (error) {
    errors << "mbgatectl: " << *error << '\n';
  }
  const bool faulty = std::ranges::any_of(
      findings, [](const Finding& finding) { return finding.verdict == Judgement::fault; });
  return error || faulty ? kExitNotDone : kExitDone;
}

}  // namespace

int run(const DoctorCommand& command, std::ostream& out, std::ostream& errors) {
  if (command.port) {
    return examine_and_print(plan_of_port(command), command, out, errors);
  }
  const auto loaded = config::load_settings(command.config, {.folder = command.folder});
  if (!loaded.settings) {
    errors << config::render(loaded.diagnostics) << std::flush;
    return command.json ? report_failure({kExitConfiguration, "the configuration has errors"}, true,
                                         out, errors)
                        : kExitConfiguration;
  }
  const auto plan = plan_of_bus(command, *loaded.settings);
  if (!plan) {
    return report_failure({kExitUsage, plan.error()}, command.json, out, errors);
  }
  return examine_and_print(*plan, command, out, errors);
}

}  // namespace mbgate::ctl

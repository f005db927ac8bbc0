// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <ostream>

#include "config/toml/duration_text.hpp"
#include "ctl/doctor/examination_shell.hpp"
#include "ctl/request/carry_out.hpp"
#include "ctl/request/report.hpp"

namespace mbgate::ctl {
namespace {

std::string announcement(const LinePlan& plan, const DoctorCommand& command) {
  std::string text = "examining " + plan.device + " at " + mode_text(plan.mode) + ": listens for " +
                     config::to_text(command.listen);
  if (!plan.nobody) {
    text += ", then reads holding register " + std::to_string(command.holding_register) + " " +
            number_of_text(command.requests, "time") +
            (plan.units.size() == 1 ? " of " + unit_text(plan.units.front())
                                    : " of each of " + number_of_text(plan.units.size(), "unit"));
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

int examine_line(const DoctorCommand& command, std::ostream& out, std::ostream& errors) {
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

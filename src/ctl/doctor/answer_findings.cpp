// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <fmt/format.h>
#include <string_view>

#include "base/text.hpp"
#include "config/toml/toml_value.hpp"
#include "ctl/doctor/findings.hpp"
#include "ctl/doctor/trial.hpp"
#include "modbus/codes.hpp"

namespace mbgate::ctl {
namespace {

std::string share_text(std::size_t part, std::size_t whole) {
  return fmt::format(" ({} %)", (part * 100 + whole / 2) / whole);
}

std::string times_text(const std::vector<std::chrono::nanoseconds>& times) {
  if (times.empty()) {
    return {};
  }
  return fmt::format(", {} to {} after the request, half of them within {}",
                     tenths_text(times.front()), tenths_text(times.back()),
                     tenths_text(times[(times.size() - 1) / 2]));
}

/// "3 with a bad CRC (15 %), 2 not answered": what went wrong.
std::string failures_text(const Tally& tally) {
  std::vector<std::string> parts;
  const auto add = [&](std::size_t count, std::string_view how, bool has_share = false) {
    if (count > 0) {
      parts.push_back(
          fmt::format("{} {}{}", count, how, has_share ? share_text(count, tally.asked) : ""));
    }
  };
  add(tally.bad_crcs, "with a bad CRC", true);
  add(tally.noise, "with bytes that are not a frame", true);
  add(tally.others, "with a frame that is not the answer");
  add(tally.silent, tally.overdue > 0 ? "not in time" : "not at all");
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string answered_text(const Tally& tally) {
  std::string text = fmt::format("{} of {} requests answered{}", tally.answered, tally.asked,
                                 times_text(tally.times));
  if (const auto failures = failures_text(tally); !failures.empty()) {
    text += "; " + failures;
  }
  return text;
}

std::string unanswered_text(const Tally& tally) {
  const auto text = "no answer to " + counted(tally.asked, "request");
  if (tally.silent < tally.asked) {
    return fmt::format("{}: {}", text, failures_text(tally));
  }
  if (tally.overdue > 0) {
    return text + " in time";
  }
  return text +
         (tally.echoes > 0 ? ": only the request itself was heard" : ": not a byte was heard");
}

/// The value that `response_timeout` needs: a fifth over the slowest answer, in tens of ms. The
/// device's `response_wait` comes before it.
std::string needed_timeout(const Tally& tally, const PlannedUnit& unit) {
  constexpr std::chrono::milliseconds kStep(10);
  const auto needed = tally.times.back() + tally.times.back() / 5 - unit.response_wait;
  return config::to_text((needed + kStep - std::chrono::nanoseconds(1)) / kStep * kStep);
}

/// Of a unit of which no answer was understood, while bytes came.
std::string garbled_advice(const LinePlan& plan, const std::string& scan, bool others_answer) {
  return others_answer
             ? "two devices at this address whose answers overlap, or its own rate, "
               "parity, wires or transceiver: switch it off, and see whether something "
               "still answers"
             : fmt::format("rate or parity, here {} ({}); A and B; two devices at one address",
                           mode_text(plan.mode), scan);
}

std::string nothing_advice(const LinePlan& plan, const Tally& tally, bool others_answer) {
  const auto scan = fmt::format("mbgatectl scan --device {} finds those that answer", plan.device);
  if (tally.others > 0 && tally.damaged() == 0) {
    return "a device whose answers have another address, function or length than they should, or "
           "come so late that another request had been sent; or another client on this line";
  }
  if (tally.damaged() > 0) {
    return garbled_advice(plan, scan, others_answer);
  }
  return others_answer ? "look at its power, its address, its wires, its rate and parity"
                       : fmt::format(
                             "look at power; A and B; the address of the drive; its rate and "
                             "parity, here {}: {}",
                             mode_text(plan.mode), scan);
}

std::string partly_advice(const Tally& tally, bool others_are_well) {
  std::string advice;
  if (tally.damaged() > 0) {
    advice = "look at termination, bias and shield of the line, and at motor cables beside it";
    advice += others_are_well ? "; or two devices at this address" : "";
  }
  if (tally.silent > 0 && advice.empty()) {
    return "look for a loose wire, and for a drive that is busy at times";
  }
  return advice.empty() ? "look for another client on this line" : advice;
}

std::string timeout_text(const PlannedUnit& unit) {
  const auto text = "the timeout of " + config::to_text(unit.timeout);
  return unit.response_wait.count() == 0 ? text
                                         : fmt::format("{} (with a response_wait of {})", text,
                                                       config::to_text(unit.response_wait));
}

void append_advice(Finding& finding, const std::string& advice) {
  finding.advice.append(finding.advice.empty() ? "" : "; ").append(advice);
}

/// Of a unit with answers that the gateway would not have waited for.
void judge_late(Finding& finding, const LinePlan& plan, const PlannedUnit& unit,
                const Tally& tally) {
  finding.seen += fmt::format("; {} later than {}", tally.late, timeout_text(unit));
  if (tally.times.back() - unit.timeout > plan.adapter_delay) {
    finding.verdict = Judgement::fault;
    append_advice(finding, "set response_timeout to at least " + needed_timeout(tally, unit));
    return;
  }
  finding.verdict = finding.verdict == Judgement::ok ? Judgement::unknown : finding.verdict;
  finding.seen += fmt::format(", by no more than the {} of the adapter's timer",
                              config::to_text(plan.adapter_delay));
  append_advice(finding, "with a timer of 1 ms they may be in time: run this again with it");
}

/// Of a unit with answers that came after the next request was sent, or was about to be.
void judge_overdue(Finding& finding, const PlannedUnit& unit, const Tally& tally) {
  const auto wait = config::to_text(answer_wait(unit) - unit.response_wait);
  finding.verdict = Judgement::fault;
  finding.seen += fmt::format("; {} came after more than {}", counted(tally.overdue, "answer"),
                              config::to_text(answer_wait(unit)));
  finding.advice = fmt::format(
      "set response_timeout to more than {}, and run this again; or see why the device takes so "
      "long",
      wait);
}

/// What is wrong may be of the other client's making.
void doubt(Finding& finding, const Tally& line) {
  finding.verdict = Judgement::unknown;
  finding.advice =
      line.other_client
          ? "another client is on this line: disconnect it, and run this again"
          : "noise or another client is on this line: remove the cause, and run this again";
}

Finding unit_finding(const LinePlan& plan, const UnitTrials& unit, bool others_answer,
                     bool others_are_well) {
  const auto tally = tally_of(unit);
  Finding finding{Judgement::ok, "answers of " + unit_text(unit.unit), answered_text(tally)};
  if (tally.answered == 0) {
    finding.verdict = Judgement::fault;
    finding.seen = unanswered_text(tally);
    finding.advice = nothing_advice(plan, tally, others_answer);
  } else if (tally.answered < tally.asked) {
    finding.verdict = Judgement::fault;
    finding.advice = partly_advice(tally, others_are_well);
  } else if (tally.exceptions == tally.asked) {
    finding.seen += ", with " + modbus::exception_text(*unit.trials.front().exception);
  }
  if (tally.late > 0) {
    judge_late(finding, plan, unit.unit, tally);
  }
  if (tally.overdue > 0) {
    judge_overdue(finding, unit.unit, tally);
  }
  return finding;
}

}  // namespace

std::vector<Finding> answer_findings(const LinePlan& plan, const std::vector<UnitTrials>& units) {
  const auto tallies = tallies_of(units);
  const auto line = tally_of_line(tallies);
  std::vector<Finding> findings;
  for (std::size_t at = 0; at < units.size(); ++at) {
    const auto any_other = [&](auto fits) {
      return std::ranges::any_of(
          tallies, [&](const Tally& other) { return &other != &tallies[at] && fits(other); });
    };
    const bool answer = any_other([](const Tally& other) { return other.answered > 0; });
    const bool well = any_other([](const Tally& other) { return other.answered == other.asked; });
    findings.push_back(unit_finding(plan, units[at], answer, well));
    if (line.disturbed && findings.back().verdict != Judgement::ok) {
      doubt(findings.back(), line);
    }
  }
  return findings;
}

}  // namespace mbgate::ctl

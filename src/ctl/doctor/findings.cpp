// SPDX-License-Identifier: Apache-2.0
#include "ctl/doctor/findings.hpp"

#include <boost/json.hpp>
#include <fmt/core.h>
#include <fmt/format.h>
#include <system_error>

#include "base/text.hpp"

namespace mbgate::ctl {
namespace {

const char* verdict_word(Judgement verdict) {
  switch (verdict) {
    case Judgement::ok: return "ok";
    case Judgement::fault: return "fault";
    case Judgement::unknown: return "unknown";
  }
  return "";
}

constexpr unsigned kGroupReadsAndWrites = 0060;
/// What an FTDI chip collects for no longer is no delay worth a word.
constexpr unsigned kShortTimer = 2;

/// "mbgated (process 12) has /dev/ttyUSB0 open"
std::string holders_text(const std::vector<Holder>& holders, const std::string& device) {
  const auto names = joined(holders, [](const Holder& it) {
    return fmt::format("{} (process {})", it.name, it.process);
  });
  return fmt::format("{} {} {} open", names, holders.size() == 1 ? "has" : "have", device);
}

}  // namespace

std::string finding_line(const Finding& finding) {
  return fmt::format("{:<9}{}: {}{}{}", verdict_word(finding.verdict), finding.step, finding.seen,
                     finding.advice.empty() ? "" : "; ", finding.advice);
}

std::string findings_json(const std::string& device, const std::vector<Finding>& findings,
                          const std::optional<std::string>& error) {
  boost::json::array list;
  for (const auto& finding : findings) {
    boost::json::object object{
        {"verdict", verdict_word(finding.verdict)}, {"step", finding.step}, {"seen", finding.seen}};
    if (!finding.advice.empty()) {
      object["advice"] = finding.advice;
    }
    list.push_back(std::move(object));
  }
  boost::json::object object{{"device", device}, {"findings", std::move(list)}};
  if (error) {
    object["error"] = *error;
  }
  return boost::json::serialize(object);
}

std::string tenths_text(std::chrono::nanoseconds time) {
  constexpr std::chrono::microseconds kTenth(100);
  const auto tenths = (time + kTenth / 2) / kTenth;
  return fmt::format("{}.{} ms", tenths / 10, tenths % 10);
}

Finding port_finding(const std::string& device, const PortFacts& facts) {
  if (facts.error != 0) {
    return {Judgement::fault, "port", port_failure(device, facts.error, facts.names),
            facts.names.empty() ? "is the adapter plugged in? look at dmesg" : "name one of these"};
  }
  if (!facts.is_character_device) {
    return {Judgement::fault, "port", device + " is not a serial port",
            "name a serial port, such as one in /dev/serial/by-id"};
  }
  Finding finding{Judgement::ok, "port", device + " exists"};
  if (!facts.is_lasting && !facts.leading.empty()) {
    finding.advice = fmt::format(
        "this name may change when adapters are plugged in differently; this one does not: {}",
        fmt::join(facts.leading, ", "));
  }
  return finding;
}

Finding permission_finding(const std::string& device, const PermissionFacts& facts) {
  if (facts.error == 0) {
    return {Judgement::ok, "permission", fmt::format("{} may open {}", facts.user, device)};
  }
  const auto fault = [&](const std::string& why, const std::string& advice) {
    return Finding{Judgement::fault, "permission",
                   fmt::format("{} may not open {}: {}", facts.user, device, why), advice};
  };
  if ((facts.mode & kGroupReadsAndWrites) != kGroupReadsAndWrites) {
    return fault(
        fmt::format("its mode is {:04o}, of {} and group {}", facts.mode, facts.owner, facts.group),
        "a udev rule must give it to a group, or run this with sudo");
  }
  if (facts.is_member) {
    return fault(fmt::format("{}, though a member of group {}",
                             std::generic_category().message(facts.error), facts.group),
                 "look for what else forbids it: getfacl " + device);
  }
  if (facts.becomes_member) {
    return fault(
        fmt::format("a member of group {}, but not yet in this login session", facts.group),
        "log in again");
  }
  return fault(fmt::format("not a member of group {}, which owns it", facts.group),
               fmt::format("sudo adduser {} {}, then log in again", facts.user, facts.group));
}

Finding held_finding(const std::string& device, const std::vector<Holder>& holders) {
  if (holders.empty()) {
    return {Judgement::fault, "holder", "a gateway or another program holds " + device,
            fmt::format("sudo fuser -v {} names it; stop a gateway with sudo systemctl stop "
                        "mbgated, or ask it with mbgatectl status",
                        device)};
  }
  return {Judgement::fault, "holder", holders_text(holders, device) + ", and it is locked",
          holders.front().name == "mbgated"
              ? "ask it with mbgatectl status, or stop it: sudo systemctl stop mbgated"
              : "end it first"};
}

Finding free_finding(const std::string& device, const std::vector<Holder>& others) {
  if (others.empty()) {
    return {Judgement::ok, "holder", "no other program is seen to have it open"};
  }
  return {Judgement::fault, "holder",
          holders_text(others, device) +
              " too; nothing was sent, because each program would take bytes from the others",
          "end it first"};
}

Finding latency_finding(const LatencyFacts& facts) {
  if (!facts.timer) {
    return {Judgement::unknown, "latency",
            facts.real_path + " is not an FTDI adapter, or does not show its timer"};
  }
  Finding finding{Judgement::ok, "latency",
                  fmt::format("the adapter hands bytes over after {} ms", *facts.timer)};
  if (*facts.timer <= kShortTimer) {
    return finding;
  }
  const std::string rule =
      R"(ACTION=="add", SUBSYSTEM=="usb-serial", DRIVER=="ftdi_sio", ATTR{latency_timer}="1")";
  const std::string how = "this line in /etc/udev/rules.d/99-ftdi.rules makes it 1 ms: " + rule;
  if (facts.low_latency == false) {
    finding.verdict = Judgement::fault;
    finding.seen += ", and low_latency = false leaves it so";
    finding.advice = "set low_latency = true; or " + how;
  } else {
    finding.seen += "; the times below may be too long by that";
    finding.advice = "mbgated itself asks for 1 ms (low_latency); for other programs " + how;
  }
  return finding;
}

std::chrono::milliseconds avoidable_delay(const LatencyFacts& facts) {
  const auto timer = facts.timer.value_or(0);
  const bool shortened = timer > kShortTimer && facts.low_latency != false;
  return std::chrono::milliseconds(shortened ? timer : 0);
}

Finding settings_finding(const LineMode& mode, const std::optional<std::string>& refusal,
                         bool is_pseudo_terminal) {
  if (!refusal) {
    return {is_pseudo_terminal ? Judgement::unknown : Judgement::ok, "settings",
            mode_text(mode) + (is_pseudo_terminal
                                   ? " is set, but a pseudo-terminal has no parity to read back"
                                   : " is set and was read back")};
  }
  return {Judgement::fault, "settings", mode_text(mode) + ": " + *refusal,
          "this adapter cannot do it: take another rate or parity, here and at the drives, or "
          "another adapter"};
}

}  // namespace mbgate::ctl

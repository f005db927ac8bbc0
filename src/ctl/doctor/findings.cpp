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

namespace {

constexpr unsigned kGroupReadsAndWrites = 0060;
/// What an FTDI chip collects for no longer is no delay worth a word.
constexpr unsigned kShortTimer = 2;

/// "mbgated (process 12)"
std::string holders_text(const std::vector<Holder>& holders) {
  return joined(holders, [](const Holder& it) {
    return fmt::format("{} (process {})", it.name, it.process);
  });
}

bool is_gateway(const Holder& holder) { return holder.name == "mbgated"; }

}  // namespace

Finding port_finding(const std::string& device, const PortFacts& facts) {
  Finding finding{Judgement::fault, "port", {}};
  if (facts.error != 0) {
    finding.seen = port_failure(device, facts.error, facts.names);
    finding.advice =
        facts.names.empty() ? "is the adapter plugged in? look at dmesg" : "name one of these";
  } else if (!facts.is_character_device) {
    finding.seen = device + " is not a serial port";
    finding.advice = "name a serial port, such as one in /dev/serial/by-id";
  } else {
    finding.verdict = Judgement::ok;
    finding.seen = device + " exists";
    if (!facts.is_lasting && !facts.leading.empty()) {
      finding.advice = fmt::format(
          "this name may change when adapters are plugged in differently; this one does not: {}",
          fmt::join(facts.leading, ", "));
    }
  }
  return finding;
}

Finding permission_finding(const std::string& device, const PermissionFacts& facts) {
  Finding finding{Judgement::ok, "permission", fmt::format("{} may open {}", facts.user, device)};
  if (facts.error == 0) {
    return finding;
  }
  finding.verdict = Judgement::fault;
  finding.seen = fmt::format("{} may not open {}: ", facts.user, device);
  const bool group_may = (facts.mode & kGroupReadsAndWrites) == kGroupReadsAndWrites;
  if (!group_may) {
    finding.seen +=
        fmt::format("its mode is {:04o}, of {} and group {}", facts.mode, facts.owner, facts.group);
    finding.advice = "a udev rule must give it to a group, or run this with sudo";
  } else if (facts.is_member) {
    finding.seen += fmt::format("{}, though a member of group {}",
                                std::generic_category().message(facts.error), facts.group);
    finding.advice = "look for what else forbids it: getfacl " + device;
  } else if (facts.becomes_member) {
    finding.seen +=
        fmt::format("a member of group {}, but not yet in this login session", facts.group);
    finding.advice = "log in again";
  } else {
    finding.seen += fmt::format("not a member of group {}, which owns it", facts.group);
    finding.advice = fmt::format("sudo adduser {} {}, then log in again", facts.user, facts.group);
  }
  return finding;
}

Finding held_finding(const std::string& device, const std::vector<Holder>& holders) {
  Finding finding{Judgement::fault, "holder", "a gateway or another program holds " + device};
  if (holders.empty()) {
    finding.advice = fmt::format(
        "sudo fuser -v {} names it; stop a gateway with sudo systemctl stop mbgated, or ask it "
        "with mbgatectl status",
        device);
    return finding;
  }
  finding.seen = fmt::format("{}{}{} open, and it is locked", holders_text(holders),
                             holders.size() == 1 ? " has " : " have ", device);
  finding.advice = is_gateway(holders.front())
                       ? "ask it with mbgatectl status, or stop it: sudo systemctl stop mbgated"
                       : "end it first";
  return finding;
}

Finding free_finding(const std::string& device, const std::vector<Holder>& others) {
  if (others.empty()) {
    return {Judgement::ok, "holder", "no other program is seen to have it open"};
  }
  return {Judgement::fault, "holder",
          fmt::format("{}{}{} open too; nothing was sent, because each program would take bytes "
                      "from the others",
                      holders_text(others), others.size() == 1 ? " has " : " have ", device),
          "end it first"};
}

Finding latency_finding(const LatencyFacts& facts) {
  Finding finding{Judgement::unknown, "latency", {}};
  if (!facts.timer) {
    finding.seen = facts.real_path + " is not an FTDI adapter, or does not show its timer";
    return finding;
  }
  finding.verdict = Judgement::ok;
  finding.seen = fmt::format("the adapter hands bytes over after {} ms", *facts.timer);
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

Finding settings_finding(const LineMode& mode, const std::optional<std::string>& refusal) {
  if (!refusal) {
    return {Judgement::ok, "settings", mode_text(mode) + " is set and was read back"};
  }
  return {Judgement::fault, "settings", mode_text(mode) + ": " + *refusal,
          "this adapter cannot do it: take another rate or parity, here and at the drives, or "
          "another adapter"};
}

}  // namespace mbgate::ctl

// SPDX-License-Identifier: Apache-2.0
#include "ctl/doctor/port_findings.hpp"

#include <array>
#include <cstdio>
#include <system_error>

#include "ctl/serial/serial_port.hpp"

namespace mbgate::ctl {
namespace {

constexpr unsigned kGroupReadsAndWrites = 0060;
/// What an FTDI chip collects for no longer is no delay worth a word.
constexpr unsigned kShortTimer = 2;

std::string listed_names(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) {
    text.append(text.empty() ? "" : ", ").append(name);
  }
  return text;
}

std::string octal(unsigned mode) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%04o", mode);
  return text.data();
}

/// "mbgated (process 12)"
std::string holders_text(const std::vector<Holder>& holders) {
  std::string text;
  for (const auto& holder : holders) {
    text.append(text.empty() ? "" : ", ").append(holder.name);
    text.append(" (process ").append(std::to_string(holder.process)).append(")");
  }
  return text;
}

bool is_gateway(const Holder& holder) { return holder.name == "mbgated"; }

}  // namespace

Finding port_finding(const std::string& device, const PortFacts& facts) {
  Finding finding{Judgement::fault, "port", {}};
  if (facts.error != 0) {
    finding.seen = port_failure(device, facts.error, facts.names);
    finding.advice = facts.names.empty() ? "is the adapter plugged in? dmesg says so"
                                         : "name one of those that there are";
  } else if (!facts.is_character_device) {
    finding.seen = device + " is no serial port";
    finding.advice = "name one, such as those of ls /dev/serial/by-id";
  } else {
    finding.verdict = Judgement::ok;
    finding.seen = device + " is there";
    if (!facts.is_lasting && !facts.leading.empty()) {
      finding.advice =
          "where adapters are plugged in otherwise it may be another one; this name "
          "stays: " +
          listed_names(facts.leading);
    }
  }
  return finding;
}

Finding permission_finding(const std::string& device, const PermissionFacts& facts) {
  Finding finding{Judgement::ok, "permission", facts.user + " may open " + device};
  if (facts.error == 0) {
    return finding;
  }
  finding.verdict = Judgement::fault;
  finding.seen = facts.user + " may not open " + device + ": ";
  const bool group_may = (facts.mode & kGroupReadsAndWrites) == kGroupReadsAndWrites;
  if (!group_may) {
    finding.seen +=
        "its mode is " + octal(facts.mode) + ", of " + facts.owner + " and group " + facts.group;
    finding.advice = "a udev rule must give it to a group, or run this with sudo";
  } else if (facts.is_member) {
    finding.seen +=
        std::generic_category().message(facts.error) + ", though a member of group " + facts.group;
    finding.advice = "what else forbids it? getfacl " + device;
  } else if (facts.becomes_member) {
    finding.seen += "a member of group " + facts.group + ", but not since the last login";
    finding.advice = "log in again";
  } else {
    finding.seen += "no member of group " + facts.group + ", which owns it";
    finding.advice = "sudo adduser " + facts.user + " " + facts.group + ", then log in again";
  }
  return finding;
}

Finding held_finding(const std::string& device, const std::vector<Holder>& holders) {
  Finding finding{Judgement::fault, "holder", "a gateway or another program holds " + device};
  if (holders.empty()) {
    finding.advice = "sudo fuser -v " + device +
                     " names it; a gateway is stopped with sudo systemctl stop mbgated, or asked "
                     "with mbgatectl status";
    return finding;
  }
  finding.seen = holders_text(holders) + (holders.size() == 1 ? " has " : " have ") + device +
                 " open, and it is locked";
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
          holders_text(others) + (others.size() == 1 ? " has " : " have ") + device +
              " open too; nothing was sent, because each takes bytes that are not meant for it",
          "end it first"};
}

Finding latency_finding(const LatencyFacts& facts) {
  Finding finding{Judgement::unknown, "latency", {}};
  if (!facts.timer) {
    finding.seen = facts.real_path + " is no FTDI adapter, or does not show its timer";
    return finding;
  }
  finding.verdict = Judgement::ok;
  finding.seen = "the adapter hands bytes over after " + std::to_string(*facts.timer) + " ms";
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
    finding.seen += "; so long the times below may be too long";
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

// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <fmt/core.h>

#include "base/text.hpp"
#include "config/toml/toml_value.hpp"
#include "ctl/doctor/findings.hpp"
#include "ctl/doctor/trial.hpp"
#include "ctl/serial/heard.hpp"
#include "modbus/describe.hpp"

namespace mbgate::ctl {
namespace {

/// One answer more than there should be may be a late one, of before.
constexpr std::size_t kEnoughDoubled = 2;
/// So many damaged answers, and no good one, are no accident.
constexpr std::size_t kEnoughDamaged = 3;

Finding full_echo_finding(const LinePlan& plan, bool any_answered) {
  Finding finding{Judgement::ok, "echo",
                  fmt::format("the port receives what it sends: each request came back{}",
                              any_answered ? " before its answer" : ", and no answer after it")};
  if (plan.echo == false) {
    finding.verdict = Judgement::fault;
    finding.seen += ", and the bus has echo = false";
    finding.advice = R"(set echo = true or "auto")";
  } else if (!plan.echo) {
    finding.advice = R"(with echo = "auto" the gateway detects this, with echo = true it knows)";
  }
  return finding;
}

Finding doubled_finding(const UnitTrials& unit, const Tally& tally, const Tally& line) {
  Finding finding{Judgement::unknown, "addresses",
                  fmt::format("{} of {} to {} had two whole answers", tally.doubled,
                              counted(tally.asked, "request"), unit_text(unit.unit))};
  if (line.other_client) {
    finding.seen += ", but another client asks on this line too";
    finding.advice = "disconnect the other client, and run this again";
  } else if (line.disturbed) {
    finding.seen += ", but other bytes came on this line without a request";
    finding.advice = "remove the cause, and run this again";
  } else if (tally.doubled < kEnoughDoubled) {
    finding.advice = "run this again: one may be a late answer to an earlier request";
  } else {
    finding.verdict = Judgement::fault;
    finding.seen += ", and no request but ours was heard";
    finding.advice = fmt::format(
        "two devices at address {}, or another client whose requests are not heard here, or an "
        "adapter that receives what it sends: switch the device off, and see whether something "
        "still answers",
        unit.unit.address);
  }
  return finding;
}

bool is_always_damaged(const Tally& tally) {
  return tally.damaged() == tally.asked && tally.asked >= kEnoughDamaged;
}

/// Two answers that overlap damage each other, but so do others.
Finding damaged_finding(const UnitTrials& unit, const Tally& tally) {
  return {Judgement::unknown, "addresses",
          fmt::format("each answer of {} is damaged (up to {}), while others answer well: two "
                      "devices whose answers overlap look like this, and so does a device with a "
                      "wrong rate or parity, bad wires or a bad transceiver",
                      unit_text(unit.unit), counted(tally.most_bytes, "byte")),
          "switch it off: if something still answers, there is a second one"};
}

constexpr std::size_t kBytesShown = 8;

std::size_t requests_in(const BusFrames& found) {
  return static_cast<std::size_t>(std::ranges::count_if(
      found.frames, [](const BusFrame& frame) { return frame.kind != FrameKind::response; }));
}

std::string first_frame_text(modbus::Bytes heard, const BusFrame& frame) {
  const auto direction =
      frame.kind == FrameKind::response ? modbus::Direction::response : modbus::Direction::request;
  return modbus::describe_rtu(heard.subspan(frame.begin, frame.size), direction);
}

/// Of a line with whole frames on it.
Finding frames_finding(const IdleLine& line, const BusFrames& found, const std::string& during) {
  const auto count = counted(found.frames.size(), "frame");
  const auto first = first_frame_text(line.heard, found.frames.front());
  if (requests_in(found) > 0) {
    return {Judgement::fault, "idle line",
            fmt::format("another client is on this line: {} heard{}, the first: {}", count, during,
                        first),
            kOneClient};
  }
  if (found.frames.size() > 1) {
    return {Judgement::fault, "idle line",
            fmt::format("{} of devices heard{}, but not the requests: another client whose "
                        "requests do not reach this port, as on four wires, the first: {}",
                        count, during, first),
            kOneClient};
  }
  return {
      Judgement::unknown, "idle line",
      fmt::format("{} heard{}: {}; a late answer to a program that has ended, or another client",
                  count, during, first),
      "run this again"};
}

/// What bytes that are no frames look like.
std::string likeness(modbus::Bytes heard) {
  const auto all = [&](std::uint8_t value) {
    return std::ranges::all_of(heard, [&](std::uint8_t byte) { return byte == value; });
  };
  // With a parity, each character of another parity reads as zero too (INPCK).
  if (all(0x00) || all(0xFF)) {
    return "looks like a line without an idle level (are A and B exchanged, is bias or termination "
           "missing, is a wire loose?), or like another client at another rate or parity";
  }
  return "looks like noise (termination, bias, shield, motor cables beside it), or like another "
         "client at another rate or parity";
}

}  // namespace

std::optional<Finding> foreign_finding(const Unasked& before,
                                       const std::vector<UnitTrials>& units) {
  std::vector<Unasked> all{before};
  for (const auto& unit : units) {
    for (const auto& trial : unit.trials) {
      all.push_back({.other_client = trial.other_client});
      all.push_back(trial.after);
    }
  }
  const auto other = std::ranges::find_if(
      all, [](const Unasked& unasked) { return !unasked.other_client.empty(); });
  if (other != all.end()) {
    return Finding{Judgement::fault, "other client",
                   fmt::format("a request of another client was heard: {}; no more requests were "
                               "sent",
                               other->other_client),
                   kOneClient};
  }
  const auto foreign = std::ranges::find_if(all, &Unasked::is_foreign);
  if (foreign == all.end()) {
    return std::nullopt;
  }
  return Finding{
      Judgement::fault, "between requests",
      counted(foreign->bytes, "byte") + " came without a request; no more requests were sent",
      "looks like noise (termination, bias, shield, motor cables beside it), or like another "
      "client, maybe at another rate or parity"};
}

Finding echo_finding(const LinePlan& plan, const std::vector<UnitTrials>& units) {
  const auto line = tally_of_line(tallies_of(units));
  if (line.echoes == line.asked) {
    return full_echo_finding(plan, line.answered > 0);
  }
  if (line.echoes > 0) {
    return {Judgement::fault, "echo",
            fmt::format("{} of {} came back as they were sent, the others did not", line.echoes,
                        counted(line.asked, "request")),
            "look for another client that sends at the same time, and for an adapter that loses "
            "bytes"};
  }
  Finding finding{Judgement::ok, "echo", "no request came back to the port"};
  if (plan.echo == true) {
    finding.verdict = line.answered > 0 ? Judgement::fault : Judgement::unknown;
    finding.seen += ", but the bus has echo = true";
    finding.advice = line.answered > 0 ? R"(set echo = false or "auto")"
                                       : "no valid frame was received on this line";
  }
  return finding;
}

Finding addresses_finding(const std::vector<UnitTrials>& units) {
  const auto tallies = tallies_of(units);
  const auto line = tally_of_line(tallies);
  const auto doubled = std::ranges::max_element(tallies, {}, &Tally::doubled);
  if (doubled != tallies.end() && doubled->doubled > 0) {
    return doubled_finding(units[static_cast<std::size_t>(doubled - tallies.begin())], *doubled,
                           line);
  }
  const auto damaged = std::ranges::find_if(tallies, &is_always_damaged);
  const bool others_are_well = std::ranges::any_of(
      tallies, [](const Tally& tally) { return tally.answered == tally.asked; });
  if (damaged != tallies.end() && others_are_well) {
    return damaged_finding(units[static_cast<std::size_t>(damaged - tallies.begin())], *damaged);
  }
  if (line.answered == 0) {
    return {Judgement::unknown, "addresses", "no answer was understood"};
  }
  return {Judgement::ok, "addresses", "no request had a second answer"};
}

Finding idle_finding(const IdleLine& line, const LineMode& mode) {
  const auto during = " in " + config::to_text(line.time);
  if (line.bytes == 0) {
    return {Judgement::ok, "idle line", "nothing was heard" + during};
  }
  const auto found = find_frames(line.heard);
  if (!found.frames.empty()) {
    return frames_finding(line, found, during);
  }
  const modbus::Bytes heard(line.heard);
  const auto seen =
      fmt::format("{} heard{} that {} not a frame at {}: {}{}", counted(line.bytes, "byte"), during,
                  line.bytes == 1 ? "is" : "are", mode_text(mode),
                  modbus::hex(heard.first(std::min(heard.size(), kBytesShown))),
                  line.bytes > kBytesShown ? " .." : "");
  if (line.bytes <= kFewBytes) {
    return {Judgement::unknown, "idle line", seen,
            "an adapter may make them when it is opened: run this again"};
  }
  return {Judgement::fault, "idle line", seen, likeness(heard)};
}

bool is_of_another_client(const IdleLine& line) {
  const auto found = find_frames(line.heard);
  return requests_in(found) > 0 || found.frames.size() > 1;
}

bool may_be_of_another_client(const IdleLine& line) { return line.bytes > kFewBytes; }

}  // namespace mbgate::ctl

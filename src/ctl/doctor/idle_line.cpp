// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <fmt/core.h>

#include "base/text.hpp"
#include "config/toml/toml_value.hpp"
#include "ctl/doctor/findings.hpp"
#include "ctl/serial/heard.hpp"
#include "modbus/describe.hpp"

namespace mbgate::ctl {
namespace {

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

// SPDX-License-Identifier: Apache-2.0
// The doctor's finding at one step, as a line for people or as JSON.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

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

}  // namespace mbgate::ctl

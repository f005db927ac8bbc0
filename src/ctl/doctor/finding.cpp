// SPDX-License-Identifier: Apache-2.0
#include "ctl/doctor/finding.hpp"

#include <boost/json.hpp>
#include <fmt/core.h>

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

}  // namespace mbgate::ctl

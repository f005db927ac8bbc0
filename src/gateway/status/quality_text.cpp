// SPDX-License-Identifier: Apache-2.0
#include "gateway/status/quality_text.hpp"

namespace mbgate::gateway {

std::string milliseconds_text(bus::Duration duration) {
  return std::to_string(std::chrono::ceil<std::chrono::milliseconds>(duration).count()) + " ms";
}

bool is_bad(const bus::QualityVerdict& verdict) {
  return verdict.quality != bus::Quality::unknown && verdict.quality != bus::Quality::good;
}

QualityFinding quality_finding(const bus::QualityVerdict& verdict, bool is_of_line) {
  switch (verdict.quality) {
    case bus::Quality::unknown:
    case bus::Quality::good: break;
    case bus::Quality::bad_crc:
      return {
          "bad CRC in " + std::to_string(verdict.percent()) + " % of its answers",
          std::to_string(verdict.count) + " of " + std::to_string(verdict.of),
          std::string("termination, bias, cable") +
              (is_of_line ? "; several devices have it; another client that sends at the same time"
                          : ", or two devices at one address")};
    case bus::Quality::no_frame:
      return {"something answers, but no valid frame",
              "bytes came after each of " + std::to_string(verdict.of) + " requests",
              "baud rate, parity, A and B exchanged, two devices at one address?"};
    case bus::Quality::late:
      return {
          "its answers come " + milliseconds_text(verdict.lateness) + " after its response timeout",
          "after " + std::to_string(verdict.count) + " of its last " + std::to_string(verdict.of) +
              " requests",
          "set response_timeout to at least " + milliseconds_text(verdict.needed)};
  }
  return {};
}

std::string quality_text(const bus::QualityNotice& notice) {
  const bus::QualityVerdict& verdict = notice.verdict;
  if (!is_bad(verdict)) {
    return "its answers are good now";
  }
  const QualityFinding found = quality_finding(verdict, !notice.address);
  return found.finding + " (" + found.evidence + ")" +
         (verdict.quality == bus::Quality::late ? "; " : ": ") + found.look_at;
}

}  // namespace mbgate::gateway

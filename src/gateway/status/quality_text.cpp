// SPDX-License-Identifier: Apache-2.0
#include "gateway/status/quality_text.hpp"

#include <fmt/core.h>

namespace mbgate::gateway {

std::string milliseconds_text(bus::Duration duration) {
  return fmt::format("{} ms", std::chrono::ceil<std::chrono::milliseconds>(duration).count());
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
          fmt::format("bad CRC in {} % of its answers", verdict.percent()),
          fmt::format("{} of {}", verdict.count, verdict.of),
          fmt::format("termination, bias, cable{}",
                      is_of_line
                          ? "; several devices have it; another client that sends at the same time"
                          : ", or two devices at one address")};
    case bus::Quality::no_frame:
      return {"something answers, but no valid frame",
              fmt::format("bytes came after each of {} requests", verdict.of),
              "baud rate, parity, A and B exchanged, two devices at one address?"};
    case bus::Quality::late:
      return {fmt::format("its answers come {} after its response timeout",
                          milliseconds_text(verdict.lateness)),
              fmt::format("after {} of its last {} requests", verdict.count, verdict.of),
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
  return fmt::format("{} ({}){}{}", found.finding, found.evidence,
                     verdict.quality == bus::Quality::late ? "; " : ": ", found.look_at);
}

}  // namespace mbgate::gateway

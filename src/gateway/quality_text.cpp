// SPDX-License-Identifier: Apache-2.0
#include "gateway/quality_text.hpp"

namespace mbgate::gateway {
namespace {

std::string whole_milliseconds(bus::Duration duration) {
  return std::to_string(std::chrono::ceil<std::chrono::milliseconds>(duration).count()) + " ms";
}

}  // namespace

std::string quality_text(const bus::QualityNotice& notice) {
  const bus::QualityVerdict& verdict = notice.verdict;
  const std::string share =
      std::to_string(verdict.count) + " of " + std::to_string(verdict.of) + ")";
  switch (verdict.quality) {
    case bus::Quality::unknown:
    case bus::Quality::good: return "its answers are good now";
    case bus::Quality::bad_crc:
      return "bad CRC in " + std::to_string(verdict.percent()) + " % of its answers (" + share +
             ": termination, bias, cable" +
             (notice.address ? ", or two devices at one address" : "; several devices have it");
    case bus::Quality::no_frame:
      return "something answers, but no valid frame (bytes came after each of " +
             std::to_string(verdict.of) + " requests): baud rate, parity, A and B exchanged?";
    case bus::Quality::late:
      return "its answers come " + whole_milliseconds(verdict.lateness) +
             " after its response timeout (after " + std::to_string(verdict.count) +
             " of its last " + std::to_string(verdict.of) +
             " requests); set response_timeout to at least " + whole_milliseconds(verdict.needed);
  }
  return {};
}

}  // namespace mbgate::gateway

// SPDX-License-Identifier: Apache-2.0
// What is heard on a line, and what came of requests, for the tests of the doctor.
#pragma once

#include <vector>

#include "ctl/doctor/trial.hpp"
#include "modbus/frames.hpp"
#include "printed_finding.hpp"

namespace mbgate::ctl {

using LineBytes = std::vector<std::uint8_t>;

inline LineBytes rtu_frame(std::uint8_t unit, const LineBytes& pdu) {
  const auto frame = modbus::encode_rtu(unit, *modbus::Pdu::from(pdu));
  return {frame.begin(), frame.end()};
}

inline LineBytes one_after_the_other(const std::vector<LineBytes>& parts) {
  LineBytes all;
  for (const auto& part : parts) {
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

/// Function 03: register 0, one of them; and the answer 0x1234.
inline const LineBytes kReadPdu{0x03, 0x00, 0x00, 0x00, 0x01};
inline const LineBytes kAnswerPdu{0x03, 0x02, 0x12, 0x34};

inline Trial answered_after(std::chrono::microseconds took) {
  Trial trial{HeardKind::answer};
  trial.answers = 1;
  trial.took = took;
  return trial;
}

/// `count` trials that went the same way.
inline std::vector<Trial> trials(std::size_t count, const Trial& each) {
  return std::vector<Trial>(count, each);
}

inline UnitTrials trials_of(std::uint8_t unit, std::vector<Trial> trials) {
  return {{.address = unit, .timeout = std::chrono::milliseconds(300)}, std::move(trials)};
}

inline LinePlan plan_of_line() {
  return {"/dev/ttyUSB0", {modbus::Baud{9600}, {8, modbus::Parity::even, 1}}};
}

}  // namespace mbgate::ctl

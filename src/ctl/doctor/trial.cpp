// SPDX-License-Identifier: Apache-2.0
#include "ctl/doctor/trial.hpp"

#include <algorithm>

#include "ctl/doctor/bus_frames.hpp"

namespace mbgate::ctl {
namespace {

/// When byte number `place` came.
std::chrono::nanoseconds time_of(const std::vector<Piece>& pieces, std::size_t place) {
  std::size_t end = 0;
  for (const auto& piece : pieces) {
    end += piece.bytes.size();
    if (place < end) {
      // At a pseudo-terminal nothing takes the time that it takes on a wire.
      return std::max<std::chrono::nanoseconds>(piece.at, std::chrono::nanoseconds(0));
    }
  }
  return {};
}

}  // namespace

Trial understand(const SentRead& sent, const std::vector<Piece>& pieces) {
  std::vector<std::uint8_t> all;
  for (const auto& piece : pieces) {
    all.insert(all.end(), piece.bytes.begin(), piece.bytes.end());
  }
  const auto heard = sent.understand(all);
  Trial trial{heard.kind};
  trial.bytes = heard.bytes;
  trial.other_unit = heard.unit;
  const auto echo_size = all.size() - heard.bytes;
  trial.echo = echo_size > 0;
  if (heard.response && heard.response->is_exception()) {
    trial.exception = heard.response->bytes()[1];
  }
  const auto rest = modbus::Bytes(all).subspan(echo_size);
  for (const auto& frame : find_frames(rest).frames) {
    if (sent.answer_in(rest.subspan(frame.begin, frame.size))) {
      if (++trial.answers == 1) {
        trial.took = time_of(pieces, echo_size + frame.begin);
      }
    } else if (frame.kind == FrameKind::request) {
      trial.other_client = true;
    }
  }
  return trial;
}

}  // namespace mbgate::ctl

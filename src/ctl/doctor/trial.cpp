// SPDX-License-Identifier: Apache-2.0
#include "ctl/doctor/trial.hpp"

#include <algorithm>

#include "ctl/doctor/bus_frames.hpp"
#include "modbus/describe.hpp"

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

bool is_request(const BusFrame& frame) { return frame.kind != FrameKind::response; }

std::string request_text(modbus::Bytes frame) {
  return modbus::describe_rtu(frame, modbus::Direction::request);
}

/// The last request among these bytes that is not ours, in words.
std::string other_request_in(const SentRead& sent, modbus::Bytes heard) {
  std::string text;
  for (const auto& frame : find_frames(heard).frames) {
    const auto bytes = heard.subspan(frame.begin, frame.size);
    if (is_request(frame) && !std::ranges::equal(bytes, sent.frame()) && !sent.answer_in(bytes)) {
      text = request_text(bytes);
    }
  }
  return text;
}

}  // namespace

bool Unasked::is_foreign() const { return bytes > kFewBytes || !other_client.empty(); }

Trial understand(const SentRead& sent, const std::vector<Piece>& pieces) {
  std::vector<std::uint8_t> all;
  for (const auto& piece : pieces) {
    all.insert(all.end(), piece.bytes.begin(), piece.bytes.end());
  }
  const auto heard = sent.understand(all);
  Trial trial{heard.kind};
  trial.bytes = heard.bytes;
  trial.other_unit = heard.unit;
  const auto echo = sent.echo_in(all);
  trial.echo = echo.has_value();
  if (heard.response && heard.response->is_exception()) {
    trial.exception = heard.response->bytes()[1];
  }
  // Divided at the echo: what is before it and its begin could look like a frame together.
  const auto begin = all.size() - heard.bytes;
  const auto rest = modbus::Bytes(all).subspan(begin);
  trial.other_client = other_request_in(sent, modbus::Bytes(all).first(echo.value_or(0)));
  if (trial.other_client.empty()) {
    trial.other_client = other_request_in(sent, rest);
  }
  for (const auto& frame : find_frames(rest).frames) {
    if (sent.answer_in(rest.subspan(frame.begin, frame.size)) && ++trial.answers == 1) {
      trial.took = time_of(pieces, begin + frame.begin);
    }
  }
  return trial;
}

Unasked understand_unasked(const modbus::TableRange& read, const std::vector<std::uint8_t>& asked,
                           modbus::Bytes heard) {
  const auto found = find_frames(heard);
  Unasked unasked;
  unasked.bytes = found.stray;
  for (const auto& frame : found.frames) {
    const auto bytes = heard.subspan(frame.begin, frame.size);
    const SentRead sent(frame.unit, read);
    const bool was_asked = std::ranges::find(asked, frame.unit) != asked.end();
    if (was_asked && std::ranges::equal(bytes, sent.frame())) {
      continue;  // a late echo
    }
    if (was_asked && sent.answer_in(bytes)) {
      unasked.late_answers += frame.unit == asked.back() ? 1 : 0;
    } else if (is_request(frame)) {
      unasked.other_client = request_text(bytes);
    } else {
      unasked.bytes += frame.size;
    }
  }
  return unasked;
}

}  // namespace mbgate::ctl

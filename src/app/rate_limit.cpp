// SPDX-License-Identifier: Apache-2.0
#include "app/rate_limit.hpp"

#include <utility>

namespace mbgate::app {

RateLimit::Verdict RateLimit::count(const std::string& kind, bus::Instant now) {
  Window& window = windows_.try_emplace(kind, Window{now}).first->second;
  if (now - window.begin >= kWindow) {
    window.begin = now;
    window.lines = 0;
  }
  if (window.lines == kLinesPerWindow) {
    ++window.left_out;
    return {};
  }
  ++window.lines;
  return {true, window.lines == kLinesPerWindow, std::exchange(window.left_out, 0)};
}

}  // namespace mbgate::app

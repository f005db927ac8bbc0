// SPDX-License-Identifier: Apache-2.0
#include "io/lines/line.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "io/lines/serial_line.hpp"
#include "io/lines/tcp_line.hpp"

namespace mbgate::io {

std::unique_ptr<Line> make_line(const LineContext& context, drive::BusId bus,
                                const bus::LineSettings& line) {
  if (line.remote) {
    return std::make_unique<TcpLine>(context, bus, line);
  }
  return std::make_unique<SerialLine>(context, bus, line);
}

Line& LineSet::with_settings(drive::BusId bus, const bus::LineSettings& settings) {
  const auto number = static_cast<std::size_t>(bus);
  lines_.resize(std::max(lines_.size(), number + 1));
  Entry& entry = lines_[number];
  const bool changed = entry.line != nullptr && !(entry.settings == settings);
  if (changed && !entry.line->adopt(settings)) {
    retired_.push_back(std::move(entry.line));
  }
  if (entry.line == nullptr) {
    entry.line = make_line(context_, bus, settings);
  }
  entry.settings = settings;
  return *entry.line;
}

LineSet::~LineSet() {
  // What must be done before the process ends, such as dropping output, comes first in a close.
  constexpr std::chrono::milliseconds kLongest{150};
  for (const Entry& entry : lines_) {
    if (entry.line != nullptr) {
      entry.line->close();
    }
  }
  context_.closing->wait_for_all(kLongest);
}

void LineSet::read_now() {
  for (const Entry& entry : lines_) {
    if (entry.line != nullptr) {
      entry.line->read_now();
    }
  }
}

}  // namespace mbgate::io

// SPDX-License-Identifier: Apache-2.0
// The lines of all buses. A reload may change a line; the next open() uses the new settings.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "io/lines/line.hpp"

namespace mbgate::io {

class LineSet {
 public:
  explicit LineSet(LineContext context) : context_(std::move(context)) {}

  /// The line of the bus, which must have been opened before.
  Line& operator[](drive::BusId bus) { return *lines_[static_cast<std::size_t>(bus)].line; }
  /// The line of the bus with these settings. If they differ from before, the line must have been
  /// closed.
  Line& with_settings(drive::BusId bus, const bus::LineSettings& settings);
  /// Reads what can be read from all of them.
  void read_now();

 private:
  struct Entry {
    std::unique_ptr<Line> line;  ///< none: never opened
    bus::LineSettings settings;
  };
  LineContext context_;
  std::vector<Entry> lines_;
  /// Lines that were closed and replaced by lines of another kind. A thread may still report to
  /// them.
  std::vector<std::unique_ptr<Line>> retired_;
};

}  // namespace mbgate::io

// SPDX-License-Identifier: Apache-2.0
// The lines of all buses. A reload may change what a line is: the next opening is of what the
// settings say then.
#pragma once

#include <memory>
#include <vector>

#include "io/lines/line.hpp"

namespace mbgate::io {

class LineSet {
 public:
  explicit LineSet(LineContext context) : context_(context) {}

  /// One that was opened before.
  Line& operator[](drive::BusId bus) { return *lines_[static_cast<std::size_t>(bus)].line; }
  /// The line of the bus as `settings` have it. One that they change must have been closed.
  Line& with_settings(drive::BusId bus, const bus::LineSettings& settings);
  /// Hands over what lies in their descriptors.
  void read_now();

 private:
  struct Entry {
    std::unique_ptr<Line> line;  ///< none: never opened
    bus::LineSettings settings;
  };
  LineContext context_;
  std::vector<Entry> lines_;
  /// Closed, and replaced by lines of another kind. A thread may still be about to report to them.
  std::vector<std::unique_ptr<Line>> retired_;
};

}  // namespace mbgate::io

// SPDX-License-Identifier: Apache-2.0
// Prints the events of a trace, each as it comes: as text or JSON, into a capture, or both.
#pragma once

#include <cstddef>
#include <iosfwd>
#include <optional>

#include "ctl/control/event_reader.hpp"
#include "ctl/trace/trace_capture.hpp"

namespace mbgate::ctl {

class TracePrinter {
 public:
  struct Ways {
    std::ostream* text = nullptr;  ///< nothing: not printed
    bool json = false;             ///< one object a line instead of text
    std::ostream* capture = nullptr;
    std::optional<std::size_t> times;  ///< records until it is done
  };

  explicit TracePrinter(const Ways& ways) : ways_(ways) {}

  /// Writes what stands before the first event. False: it cannot be written.
  bool start();
  /// False: nothing more is wanted, or it cannot be written. An exception says what is not as
  /// mbgated sends it.
  bool take(const ServerEvent& event);
  /// As many as were wanted have come.
  [[nodiscard]] bool is_done() const { return ways_.times && taken_ >= *ways_.times; }

 private:
  [[nodiscard]] bool is_read() const;
  void take_lost(const ServerEvent& event);
  void take_record(const ServerEvent& event);
  void put(const ByteString& blocks);
  [[nodiscard]] bool is_written() const;

  Ways ways_;
  TraceCapture capture_;
  std::size_t taken_ = 0;
};

}  // namespace mbgate::ctl

// SPDX-License-Identifier: Apache-2.0
// Prints the events of a trace, each as it comes: as text or JSON, into a capture, or both.
#pragma once

#include <cstddef>
#include <iosfwd>
#include <optional>
#include <string>

#include "ctl/control/event_reader.hpp"
#include "ctl/request/command.hpp"
#include "ctl/trace/trace_capture.hpp"

namespace mbgate::ctl {

class TracePrinter {
 public:
  struct Ways {
    std::ostream* text = nullptr;  ///< here and below, nothing: not printed
    std::ostream* json = nullptr;  ///< one object a line
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
  void look_into(const ServerEvent& event);
  void put(const ByteString& blocks);
  /// Flushes all. False: something cannot be written.
  [[nodiscard]] bool is_written() const;

  Ways ways_;
  TraceCapture capture_;
  std::size_t taken_ = 0;
};

/// What mbgated is asked for a trace: "/api/v1/trace?bus=line-a&only=failed"; what is not a letter,
/// digit or one of -._~ goes as the percent-encoded octets of its UTF-8 (RFC 3986, 2.1).
std::string trace_target(const TraceFilter& filter);

}  // namespace mbgate::ctl

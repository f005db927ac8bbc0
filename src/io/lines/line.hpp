// SPDX-License-Identifier: Apache-2.0
// What a bus is attached to: a serial line, or a TCP connection in place of one. A line only tries:
// when to open again is the machine's decision.
#pragma once

#include <boost/asio/io_context.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/job.hpp"
#include "bus/settings.hpp"
#include "io/blocking_calls.hpp"
#include "io/lines/closing_ports.hpp"
#include "modbus/bytes.hpp"

namespace mbgate::io {

class LineEvents {
 public:
  virtual ~LineEvents() = default;
  virtual void line_opened(drive::BusId bus, bus::LineKind kind,
                           const std::vector<std::string>& warnings) = 0;
  virtual void line_bytes(drive::BusId bus, modbus::Bytes bytes) = 0;
  /// It could not be opened, or it died. `why` is one line that names the far end.
  virtual void line_lost(drive::BusId bus, const std::string& why) = 0;
  /// The far end of an open connection has closed it.
  virtual void line_closed(drive::BusId bus, const std::string& why) = 0;
};

/// What the lines of one io thread share.
struct LineContext {
  boost::asio::io_context& io;
  BlockingCalls& blocking;
  LineEvents& events;
  std::shared_ptr<ClosingPorts> closing = std::make_shared<ClosingPorts>();
};

class Line {
 public:
  Line() = default;
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;
  virtual ~Line() = default;

  /// Ends in line_opened() or line_lost(), never from within. Ignored while the line is open or
  /// being opened.
  virtual void open() = 0;
  /// One write of the whole frame, at once. What is not taken is written as soon as it is, within a
  /// limit. Why the line is dead, or nothing; a dead line is closed already and line_lost() is not
  /// called. One that is not open was reported before, and takes nothing.
  [[nodiscard]] virtual std::optional<std::string> transmit(modbus::Bytes frame) = 0;
  /// Hands over what lies in the descriptor now, and nothing that comes while it does:
  /// line_bytes(), or line_lost() if the line turns out to be dead, from within. Nothing on a line
  /// that is not open.
  virtual void read_now() = 0;
  /// Does anything lie in the descriptor?
  [[nodiscard]] virtual bool has_bytes() = 0;
  /// Also ends an opening. Nothing is reported until the next open().
  virtual void close() = 0;
  /// What the next open() is to open; the line must be closed. False: this object cannot, and
  /// another one is needed.
  [[nodiscard]] virtual bool adopt(const bus::LineSettings& settings) = 0;
};

/// What these settings ask for: a TCP connection if they name a remote end, else a serial line.
std::unique_ptr<Line> make_line(LineContext context, drive::BusId bus,
                                const bus::LineSettings& line);

}  // namespace mbgate::io

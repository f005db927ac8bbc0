// SPDX-License-Identifier: Apache-2.0
// The line that a bus is attached to: a serial line, or a TCP connection in place of one. Each
// open() is a single attempt; the machine decides when to try again.
//
// To change
// - serial port settings: raw mode, lock: sys/tty; for a line: tty*.
#pragma once

#include <algorithm>
#include <boost/asio/error.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/system/error_code.hpp>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bus/job.hpp"
#include "bus/settings.hpp"
#include "io/blocking_calls.hpp"
#include "io/lines/open_ends.hpp"
#include "modbus/bytes.hpp"
#include "modbus/frames.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::io {

class LineEvents {
 public:
  virtual ~LineEvents() = default;
  virtual void line_opened(drive::BusId bus, bus::LineKind kind,
                           const std::vector<std::string>& warnings) = 0;
  virtual void line_bytes(drive::BusId bus, modbus::Bytes bytes) = 0;
  /// The driver holds so many bytes that it has not sent: another number than before.
  virtual void line_unsent(drive::BusId bus, std::size_t bytes) = 0;
  /// The line could not be opened, or was lost. `why` is one line of text that names the port or
  /// server.
  virtual void line_lost(drive::BusId bus, const std::string& why) = 0;
  /// The server has closed an open connection.
  virtual void line_closed(drive::BusId bus, const std::string& why) = 0;
  /// Of the bus, for texts about another one.
  [[nodiscard]] virtual std::string name_of(drive::BusId /*bus*/) const { return "another"; }
};

/// What the lines of one io thread share.
struct LineContext {
  boost::asio::io_context& io;
  BlockingCalls& blocking;
  LineEvents& events;
  std::shared_ptr<ClosingPorts> closing = std::make_shared<ClosingPorts>();
  std::shared_ptr<OpenEnds> ends = std::make_shared<OpenEnds>();
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
  /// Writes the whole frame with one call, at once. What the kernel does not take is written as
  /// soon as possible, within a limit. Returns why the line is dead, or nothing. A dead line is
  /// closed already, and line_lost() is not called. A line that is not open was reported before,
  /// and ignores the frame.
  [[nodiscard]] virtual std::optional<std::string> transmit(modbus::Bytes frame) = 0;
  /// Reads what can be read now, and nothing that comes meanwhile. Calls line_bytes() and
  /// line_unsent(), or line_lost() if the line turns out to be dead, from within. Does nothing on a
  /// line that is not open.
  virtual void read_now() = 0;
  /// Is there anything to read?
  [[nodiscard]] virtual bool has_bytes() = 0;
  /// Closes the line, or cancels an attempt to open it. Nothing is reported until the next open().
  virtual void close() = 0;
  /// New settings for the next open(); the line must be closed. False: this object cannot use them,
  /// and another one is needed.
  [[nodiscard]] virtual bool adopt(const bus::LineSettings& settings) = 0;
};

/// The line for these settings: a TCP connection if they have `remote`, else a serial line.
std::unique_ptr<Line> make_line(const LineContext& context, drive::BusId bus,
                                const bus::LineSettings& line);

// Reads what is waiting in a line's descriptor, and nothing that arrives meanwhile: a peer that
// never stops sending must not block the io thread.

/// So much of a line is read at once: a framer has room for that behind a frame that has begun.
inline constexpr std::size_t kLineReadSize = 2 * modbus::kMaxRtuSize;

/// Reads in pieces that fit `buffer`: one, unless that is full; then `available` says how many
/// bytes are left. `read` gets the buffer and does what ::read() does. `hand_over` gets the bytes
/// that came, and returns whether the line is still the same. Returns why the line is dead: an
/// errno, or eof; no error otherwise.
template <class Read, class Available, class HandOver>
[[nodiscard]] boost::system::error_code read_waiting(std::span<std::uint8_t> buffer, Read read,
                                                     Available available, HandOver hand_over) {
  bool asked = false;
  for (std::size_t left = buffer.size(); left > 0;) {
    const auto room = buffer.first(std::min(left, buffer.size()));
    const auto count = read(room);
    if (count == 0) {
      return boost::asio::error::make_error_code(boost::asio::error::eof);
    }
    if (count < 0) {
      return sys::would_block(errno)
                 ? boost::system::error_code()
                 : boost::system::error_code(errno, boost::system::system_category());
    }
    const auto bytes = static_cast<std::size_t>(count);
    if (!hand_over(modbus::Bytes(buffer).first(bytes)) || bytes < room.size()) {
      break;
    }
    left = std::exchange(asked, true) ? left - bytes : available();
  }
  return {};
}

/// The lines of all buses. A reload may change a line; the next open() uses the new settings.
class LineSet {
 public:
  explicit LineSet(LineContext context) : context_(std::move(context)) {}
  LineSet(const LineSet&) = delete;
  LineSet& operator=(const LineSet&) = delete;
  /// Closes all lines at once: some drivers sleep for a quarter of a second in each close().
  ~LineSet();

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

// SPDX-License-Identifier: Apache-2.0
// One serial line: opened and closed on a thread that may wait, read and written on the io thread.
// It only tries: when to open again is the machine's decision.
#pragma once

#include <array>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bus/job.hpp"
#include "bus/settings.hpp"
#include "io/blocking_calls.hpp"
#include "io/tty.hpp"
#include "modbus/bytes.hpp"
#include "modbus/rtu.hpp"

namespace mbgate::io {

class LineEvents {
 public:
  virtual ~LineEvents() = default;
  virtual void line_opened(drive::BusId bus, const std::vector<std::string>& warnings) = 0;
  virtual void line_bytes(drive::BusId bus, modbus::Bytes bytes) = 0;
  /// It could not be opened, or it died. `why` is one line that names the device.
  virtual void line_lost(drive::BusId bus, const std::string& why) = 0;
};

/// What the lines of one io thread share.
struct LineContext {
  boost::asio::io_context& io;
  BlockingCalls& blocking;
  LineEvents& events;
};

class SerialLine {
 public:
  SerialLine(LineContext context, drive::BusId bus, bus::LineSettings settings);
  SerialLine(const SerialLine&) = delete;
  SerialLine& operator=(const SerialLine&) = delete;
  ~SerialLine();

  /// Ends in line_opened() or line_lost(), never from within. Ignored while the line is open or
  /// being opened.
  void open();
  /// One write of the whole frame, at once. What the driver does not take is written as soon as it
  /// does. Why the line is dead, or nothing; a dead line is closed already and line_lost() is not
  /// called.
  std::optional<std::string> transmit(modbus::Bytes frame);
  /// Hands the descriptor to a thread that may wait; line_lost() is not called.
  void close();

 private:
  enum class State : std::uint8_t { closed, opening, open };

  boost::asio::awaitable<void> read_loop(unsigned generation);
  boost::asio::awaitable<void> write_rest(unsigned generation);
  boost::asio::awaitable<void> limit_writing(unsigned generation);
  boost::asio::awaitable<void> release_rts(unsigned generation);
  void finish_open(Result<OpenTty, std::string> result);
  void lose(const std::string& why);
  [[nodiscard]] std::string error_text(const char* action, int error) const;

  LineContext context_;
  drive::BusId bus_;
  bus::LineSettings settings_;
  modbus::RtuTiming timing_;
  boost::asio::posix::stream_descriptor descriptor_;
  boost::asio::steady_timer timer_;
  State state_ = State::closed;
  /// Counts the openings, so that a coroutine of an earlier one notices that its line has gone.
  unsigned generation_ = 0;
  bus::FrameBytes rest_;       ///< not taken by the driver yet
  bool transmitting_ = false;  ///< a rest is left, or RTS is raised
  std::array<std::uint8_t, 2 * modbus::kMaxRtuSize> buffer_{};
};

}  // namespace mbgate::io

// SPDX-License-Identifier: Apache-2.0
// A serial line. It is opened and closed on a thread that may wait, and read and written on the io
// thread.
#pragma once

#include <array>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <optional>
#include <string>

#include "bus/settings.hpp"
#include "io/lines/line.hpp"
#include "io/lines/tty.hpp"
#include "modbus/frames.hpp"

namespace mbgate::io {

class SerialLine final : public Line {
 public:
  SerialLine(LineContext context, drive::BusId bus, bus::LineSettings settings);
  ~SerialLine() override;

  void open() override;
  std::optional<std::string> transmit(modbus::Bytes frame) override;
  void read_now() override;
  [[nodiscard]] bool has_bytes() override;
  /// Hands the descriptor to a thread that may wait.
  void close() override;
  [[nodiscard]] bool adopt(const bus::LineSettings& settings) override;

 private:
  enum class State : std::uint8_t { closed, opening, open };

  boost::asio::awaitable<void> read_loop(unsigned generation);
  boost::asio::awaitable<void> write_rest(unsigned generation);
  boost::asio::awaitable<void> limit_writing(unsigned generation);
  boost::asio::awaitable<void> release_rts(unsigned generation);
  void finish_open(Result<OpenTty, std::string> result, const bus::LineSettings& opened,
                   unsigned generation);
  void close_elsewhere(sys::UniqueFd fd, const bus::LineSettings& opened);
  void lose(const std::string& why);
  [[nodiscard]] boost::system::error_code read();
  [[nodiscard]] std::string error_text(const char* action, int error) const;

  LineContext context_;
  drive::BusId bus_;
  bus::LineSettings settings_;
  modbus::RtuTiming timing_;
  boost::asio::posix::stream_descriptor descriptor_;
  boost::asio::steady_timer timer_;
  State state_ = State::closed;
  std::shared_future<void> closed_;  ///< ready once the previous descriptor is closed
  /// Counts openings and closings, so that what belongs to an earlier opening notices that its line
  /// is closed.
  unsigned generation_ = 0;
  bus::FrameBytes rest_;       ///< not taken by the driver yet
  std::size_t unsent_ = 0;     ///< what the driver held when it was asked last
  bool has_sent_all_ = false;  ///< it held nothing then, and was given nothing since
  bool transmitting_ = false;  ///< a rest is left, or RTS is raised
  std::array<std::uint8_t, kLineReadSize> buffer_{};
};

}  // namespace mbgate::io

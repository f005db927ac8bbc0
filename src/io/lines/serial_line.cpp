// SPDX-License-Identifier: Apache-2.0
#include "io/lines/serial_line.hpp"

#include <unistd.h>

#include <boost/asio/post.hpp>
#include <cerrno>
#include <chrono>
#include <system_error>
#include <utility>

#include "io/lines/line.hpp"
#include "io/lines/tty_direction.hpp"
#include "io/supervise.hpp"
#include "sys/tty.hpp"

namespace mbgate::io {
namespace {

using boost::asio::error::operation_aborted;
using boost::asio::posix::descriptor_base;

/// Between two questions whether the transmitter is empty: a fraction of t3.5, so that RTS is
/// lowered before a device may answer.
constexpr std::chrono::microseconds kTransmitterPoll{200};
/// A transmitter that is not empty this long after the longest frame has had its time is stuck.
constexpr std::chrono::milliseconds kTransmitterLimit{500};

/// A device can be had once at a time. One that cannot be given back for longer is tried all the
/// same: its path may lead to another one by now.
constexpr std::chrono::seconds kClosingLimit{5};

/// A vanished adapter reads as the end of the stream at first, then as one of these errors.
bool has_gone(const boost::system::error_code& error) {
  return error == boost::asio::error::eof || error.value() == EIO || error.value() == ENODEV ||
         error.value() == ENXIO;
}

}  // namespace

SerialLine::SerialLine(LineContext context, drive::BusId bus, bus::LineSettings settings)
    : context_(context),
      bus_(bus),
      settings_(std::move(settings)),
      timing_(settings_.baud, settings_.format),
      descriptor_(context.io),
      timer_(context.io) {}

SerialLine::~SerialLine() {
  if (state_ == State::open) {
    close_tty(sys::UniqueFd(descriptor_.release()), settings_);
  }
}

void SerialLine::open() {
  if (state_ != State::closed) {
    return;
  }
  state_ = State::opening;
  ++generation_;
  const bool started = context_.blocking.run(
      [settings = settings_, closings = Closings{closed_, context_.closing->of(settings_.device)}] {
        wait_for(closings, kClosingLimit);
        return open_tty(settings);
      },
      [this, settings = settings_, generation = generation_](Result<OpenTty, std::string> result) {
        finish_open(std::move(result), settings, generation);
      });
  if (!started) {
    boost::asio::post(context_.io, [this, generation = generation_] {
      finish_open(std::string("cannot open " + settings_.device + ": no thread is available"),
                  settings_, generation);
    });
  }
}

// `opened` says what: a reload may have given this line another port since.
void SerialLine::finish_open(Result<OpenTty, std::string> result, const bus::LineSettings& opened,
                             unsigned generation) {
  if (generation != generation_) {
    if (result) {
      close_elsewhere(std::move(result->fd), opened);
    }
    return;
  }
  state_ = State::closed;
  if (!result) {
    const auto other = context_.ends->other(this, port_end(opened.device));
    context_.events.line_lost(
        bus_, other ? opened.device + ": bus " + *other + " has this port open" : result.error());
    return;
  }
  boost::system::error_code error;
  descriptor_.assign(result->fd.get(), error);
  if (error) {
    close_elsewhere(std::move(result->fd), opened);
    context_.events.line_lost(bus_, settings_.device + ": cannot watch it: " + error.message());
    return;
  }
  result->fd.release();
  state_ = State::open;
  context_.ends->note(this, port_end(opened.device), context_.events.name_of(bus_));
  transmitting_ = false;
  unsent_ = 0;
  rest_.clear();
  supervise(context_.io, read_loop(generation_), "line read");
  context_.events.line_opened(bus_, result->kind, result->warnings);
}

std::optional<std::string> SerialLine::transmit(modbus::Bytes frame) {
  if (state_ != State::open) {
    return settings_.device + ": the line is not open";
  }
  has_sent_all_ = false;
  std::optional<std::string> error;
  if (transmitting_) {
    error = settings_.device + ": the previous frame is still not transmitted";
  } else if (settings_.rs485 == bus::Rs485::rts && !set_rts(descriptor_.native_handle(), true)) {
    error = error_text("raise RTS", errno);
  } else {
    const ssize_t count = ::write(descriptor_.native_handle(), frame.data(), frame.size());
    if (count < 0 && !sys::would_block(errno)) {
      error = error_text("write", errno);
    } else {
      const auto rest = frame.subspan(count < 0 ? 0 : static_cast<std::size_t>(count));
      rest_.assign(rest.begin(), rest.end());
    }
  }
  if (error) {
    close();
    return error;
  }
  if (!rest_.empty()) {
    transmitting_ = true;
    // What the driver does not take in time must not leave later, when nobody waits for it any
    // more.
    timer_.expires_after(timing_.duration_of(frame.size()) + kTransmitterLimit);
    supervise(context_.io, limit_writing(generation_), "line write limit");
    supervise(context_.io, write_rest(generation_), "line write");
  } else if (settings_.rs485 == bus::Rs485::rts) {
    transmitting_ = true;
    timer_.expires_after(timing_.duration_of(frame.size()));
    supervise(context_.io, release_rts(generation_), "line direction");
  }
  return std::nullopt;
}

// It waits, and reads by itself: an operation that had read already, and whose end waits its turn,
// would hold bytes back from read_now().
boost::asio::awaitable<void> SerialLine::read_loop(unsigned generation) {
  while (true) {
    const auto [error] = co_await descriptor_.async_wait(descriptor_base::wait_read, kAsTuple);
    if (error == operation_aborted || generation != generation_) {
      co_return;
    }
    if (const auto lost = error ? error : read()) {
      lose(has_gone(lost) ? settings_.device + ": the device has gone"
                          : error_text("read", lost.value()));
    }
    if (generation != generation_) {
      co_return;
    }
  }
}

bool SerialLine::has_bytes() {
  return state_ == State::open && sys::bytes_to_read(descriptor_.native_handle()) > 0;
}

// That the line is dead, read_loop() notices. A driver that holds nothing more has nothing to be
// asked about until the next frame.
void SerialLine::read_now() {
  if (state_ == State::open) {
    static_cast<void>(read());
  }
  if (state_ != State::open || has_sent_all_) {
    return;
  }
  const std::size_t unsent = sys::bytes_to_send(descriptor_.native_handle()) + rest_.size();
  has_sent_all_ = unsent == 0;
  if (std::exchange(unsent_, unsent) != unsent) {
    context_.events.line_unsent(bus_, unsent);
  }
}

boost::system::error_code SerialLine::read() {
  const int fd = descriptor_.native_handle();
  return read_waiting(
      buffer_, [fd](auto room) { return ::read(fd, room.data(), room.size()); },
      [fd] { return sys::bytes_to_read(fd); },
      [this, generation = generation_](modbus::Bytes bytes) {
        context_.events.line_bytes(bus_, bytes);
        return generation == generation_;
      });
}

boost::asio::awaitable<void> SerialLine::write_rest(unsigned generation) {
  while (!rest_.empty()) {
    const auto [error] = co_await descriptor_.async_wait(descriptor_base::wait_write, kAsTuple);
    if (error == operation_aborted || generation != generation_) {
      co_return;
    }
    const ssize_t count = ::write(descriptor_.native_handle(), rest_.data(), rest_.size());
    if (count < 0 && !sys::would_block(errno)) {
      lose(error_text("write", errno));
      co_return;
    }
    rest_.erase(rest_.begin(), rest_.begin() + (count < 0 ? 0 : count));
  }
  timer_.expires_after(std::chrono::nanoseconds(0));  // ends limit_writing()
  if (settings_.rs485 == bus::Rs485::rts) {
    // How much of the frame the driver still holds is not known: ask at once.
    co_await release_rts(generation);
  } else {
    transmitting_ = false;
  }
}

boost::asio::awaitable<void> SerialLine::limit_writing(unsigned generation) {
  const auto [error] = co_await timer_.async_wait(kAsTuple);
  if (!error && generation == generation_ && !rest_.empty()) {
    lose(settings_.device + ": the driver does not take a frame in time");
  }
}

boost::asio::awaitable<void> SerialLine::release_rts(unsigned generation) {
  const auto give_up =
      timer_.expiry() + timing_.duration_of(modbus::kMaxRtuSize) + kTransmitterLimit;
  while (true) {
    const auto [error] = co_await timer_.async_wait(kAsTuple);
    if (error == operation_aborted || generation != generation_) {
      co_return;
    }
    const auto empty = is_transmitter_empty(descriptor_.native_handle());
    if (empty.value_or(false)) {
      break;
    }
    if (!empty || std::chrono::steady_clock::now() > give_up) {
      lose(settings_.device + ": the transmitter does not become empty");
      co_return;
    }
    timer_.expires_after(kTransmitterPoll);
  }
  if (!set_rts(descriptor_.native_handle(), false)) {
    lose(error_text("lower RTS", errno));
    co_return;
  }
  transmitting_ = false;
}

void SerialLine::close() {
  state_ = State::closed;
  context_.ends->forget(this);
  ++generation_;
  timer_.cancel();
  if (descriptor_.is_open()) {
    close_elsewhere(sys::UniqueFd(descriptor_.release()), settings_);
  }
}

bool SerialLine::adopt(const bus::LineSettings& settings) {
  if (settings.remote || state_ != State::closed) {
    return false;
  }
  settings_ = settings;
  timing_ = modbus::RtuTiming(settings_.baud, settings_.format);
  return true;
}

void SerialLine::close_elsewhere(sys::UniqueFd fd, const bus::LineSettings& opened) {
  auto closed = std::make_shared<std::promise<void>>();
  closed_ = closed->get_future().share();
  context_.closing->note(opened.device, closed_);
  const auto held = std::make_shared<sys::UniqueFd>(std::move(fd));
  const auto close = [held, opened, closed] {
    close_tty(std::move(*held), opened);
    closed->set_value();
    return true;
  };
  if (!context_.blocking.run(close, [](bool) {})) {
    close();  // there is no thread; what the driver holds must not leave later all the same
  }
}

void SerialLine::lose(const std::string& why) {
  close();
  context_.events.line_lost(bus_, why);
}

std::string SerialLine::error_text(const char* action, int error) const {
  return settings_.device + ": cannot " + action + ": " + std::generic_category().message(error);
}

}  // namespace mbgate::io

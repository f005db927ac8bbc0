// SPDX-License-Identifier: Apache-2.0
#include "io/lines/tty_direction.hpp"

#include <linux/serial.h>
#include <sys/ioctl.h>

#include <cerrno>
#include <chrono>
#include <fmt/core.h>
#include <system_error>

namespace mbgate::io {
namespace {

constexpr std::uint32_t kDirectionFlags =
    SER_RS485_ENABLED | SER_RS485_RTS_ON_SEND | SER_RS485_RTS_AFTER_SEND | SER_RS485_RX_DURING_TX;

std::string flags_text(std::uint32_t flags) {
  std::string text = (flags & SER_RS485_ENABLED) != 0 ? "enabled" : "disabled";
  if ((flags & SER_RS485_RTS_ON_SEND) != 0) {
    text += ", RTS on send";
  }
  if ((flags & SER_RS485_RTS_AFTER_SEND) != 0) {
    text += ", RTS after send";
  }
  if ((flags & SER_RS485_RX_DURING_TX) != 0) {
    text += ", receiving while sending";
  }
  return text;
}

std::string direction_text(const serial_rs485& direction) {
  return fmt::format("{}, delays {} and {} ms", flags_text(direction.flags),
                     direction.delay_rts_before_send, direction.delay_rts_after_send);
}

bool same_direction(const serial_rs485& a, const serial_rs485& b) {
  return (a.flags & kDirectionFlags) == (b.flags & kDirectionFlags) &&
         a.delay_rts_before_send == b.delay_rts_before_send &&
         a.delay_rts_after_send == b.delay_rts_after_send;
}

std::string refusal(const bus::LineSettings& line, const char* action, int error) {
  if (error == ENOTTY) {
    return fmt::format(
        "{}: the driver has no RS-485 mode; use rs485 = \"off\" if the adapter switches direction "
        "by itself, as most USB adapters do, or rs485 = \"rts\"",
        line.device);
  }
  return fmt::format("{}: cannot {} rs485 = \"kernel\": {}", line.device, action,
                     std::generic_category().message(error));
}

std::uint32_t milliseconds_of(bus::Duration delay) {
  return static_cast<std::uint32_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(delay).count());
}

/// What the driver has now, from the device tree or from a program before us, with what `line` says
/// otherwise. How the transceiver is wired is known there and not here: a wrong polarity would keep
/// it silent, or sending for ever.
serial_rs485 wanted_direction(serial_rs485 present, const bus::LineSettings& line) {
  constexpr std::uint32_t kOnSend = SER_RS485_RTS_ON_SEND;
  constexpr std::uint32_t kAfterSend = SER_RS485_RTS_AFTER_SEND;
  constexpr std::uint32_t kPolarity = kOnSend | kAfterSend;
  present.flags |= SER_RS485_ENABLED;
  present.flags &= ~std::uint32_t{SER_RS485_RX_DURING_TX};
  if (line.echo.value_or(false)) {
    present.flags |= SER_RS485_RX_DURING_TX;
  }
  const auto polarity = present.flags & kPolarity;
  // Neither or both is no polarity: nobody has set one.
  const bool known = polarity != 0 && polarity != kPolarity;
  if (line.rs485_rts_on_send || !known) {
    present.flags &= ~kPolarity;
    present.flags |= line.rs485_rts_on_send.value_or(true) ? kOnSend : kAfterSend;
  }
  if (line.rs485_delay_before) {
    present.delay_rts_before_send = milliseconds_of(*line.rs485_delay_before);
  }
  if (line.rs485_delay_after) {
    present.delay_rts_after_send = milliseconds_of(*line.rs485_delay_after);
  }
  return present;
}

std::optional<std::string> use_kernel(int fd, const bus::LineSettings& line, IoControl control) {
  serial_rs485 present{};
  if (control(fd, TIOCGRS485, &present) != 0) {
    return refusal(line, "read", errno);
  }
  const serial_rs485 wanted = wanted_direction(present, line);
  serial_rs485 asked = wanted;
  if (control(fd, TIOCSRS485, &asked) != 0) {
    return refusal(line, "set", errno);
  }
  serial_rs485 real{};
  if (control(fd, TIOCGRS485, &real) != 0) {
    return refusal(line, "read back", errno);
  }
  if (!same_direction(wanted, real)) {
    return fmt::format("{}: asked for RS-485 {}; the driver took {}", line.device,
                       direction_text(wanted), direction_text(real));
  }
  return std::nullopt;
}

std::optional<std::string> use_rts(int fd, const bus::LineSettings& line, IoControl control) {
  if (!set_rts(fd, false, control)) {
    return fmt::format("{}: rs485 = \"rts\" needs an RTS line: {}", line.device,
                       std::generic_category().message(errno));
  }
  if (!is_transmitter_empty(fd, control)) {
    return fmt::format(
        "{}: rs485 = \"rts\" needs a driver that says when its transmitter is empty: {}",
        line.device, std::generic_category().message(errno));
  }
  return std::nullopt;
}

}  // namespace

int system_io_control(int fd, unsigned long request, void* argument) {
  return ::ioctl(fd, request, argument);
}

std::optional<std::string> set_direction_control(int fd, const bus::LineSettings& line,
                                                 IoControl control) {
  switch (line.rs485) {
    case bus::Rs485::off: return std::nullopt;
    case bus::Rs485::kernel: return use_kernel(fd, line, control);
    case bus::Rs485::rts: return use_rts(fd, line, control);
  }
  return std::nullopt;
}

bool set_rts(int fd, bool sending, IoControl control) {
  int lines = TIOCM_RTS;
  return control(fd, sending ? TIOCMBIS : TIOCMBIC, &lines) == 0;
}

std::optional<bool> is_transmitter_empty(int fd, IoControl control) {
  unsigned state = 0;
  if (control(fd, TIOCSERGETLSR, &state) != 0) {
    return std::nullopt;
  }
  return (state & TIOCSER_TEMT) != 0;
}

}  // namespace mbgate::io

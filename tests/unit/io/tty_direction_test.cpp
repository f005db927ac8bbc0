// SPDX-License-Identifier: Apache-2.0
// No driver of a test machine knows RS-485: a function stands in for ioctl().
#include "io/tty_direction.hpp"

#include <gtest/gtest.h>
#include <linux/serial.h>
#include <sys/ioctl.h>

#include <cerrno>

namespace mbgate::io {
namespace {

/// A driver that supports the flags it is given and drops the others, as the kernel does.
struct Driver {
  std::uint32_t supported = 0;
  std::uint32_t delay = 0;  ///< forced upon every setting
  serial_rs485 state{};
  int modem_lines = TIOCM_RTS;
  unsigned line_status = TIOCSER_TEMT;
  bool knows_line_status = true;
};

Driver driver;

int driver_io_control(int /*fd*/, unsigned long request, void* argument) {
  switch (request) {
    case TIOCSRS485:
      driver.state = *static_cast<serial_rs485*>(argument);
      driver.state.flags &= driver.supported;
      driver.state.delay_rts_before_send = driver.delay;
      return 0;
    case TIOCGRS485: *static_cast<serial_rs485*>(argument) = driver.state; return 0;
    case TIOCMBIS: driver.modem_lines |= *static_cast<int*>(argument); return 0;
    case TIOCMBIC: driver.modem_lines &= ~*static_cast<int*>(argument); return 0;
    case TIOCSERGETLSR:
      if (!driver.knows_line_status) {
        break;
      }
      *static_cast<unsigned*>(argument) = driver.line_status;
      return 0;
    default: break;
  }
  errno = ENOTTY;
  return -1;
}

bus::LineSettings line_with(bus::Rs485 rs485) {
  bus::LineSettings line;
  line.device = "/dev/ttyS7";
  line.rs485 = rs485;
  return line;
}

constexpr std::uint32_t kAll =
    SER_RS485_ENABLED | SER_RS485_RTS_ON_SEND | SER_RS485_RTS_AFTER_SEND | SER_RS485_RX_DURING_TX;

TEST(DirectionControl, ByTheKernelIsSetWithoutDelays) {
  driver = {.supported = kAll};
  EXPECT_EQ(set_direction_control(0, line_with(bus::Rs485::kernel), driver_io_control),
            std::nullopt);
  EXPECT_EQ(driver.state.flags, SER_RS485_ENABLED | SER_RS485_RTS_ON_SEND);
  EXPECT_EQ(driver.state.delay_rts_before_send, 0U);
  EXPECT_EQ(driver.state.delay_rts_after_send, 0U);
}

TEST(DirectionControl, ByTheKernelReceivesWhileSendingWhenTheEchoIsWanted) {
  driver = {.supported = kAll};
  auto line = line_with(bus::Rs485::kernel);
  line.echo = true;
  EXPECT_EQ(set_direction_control(0, line, driver_io_control), std::nullopt);
  EXPECT_EQ(driver.state.flags, SER_RS485_ENABLED | SER_RS485_RTS_ON_SEND | SER_RS485_RX_DURING_TX);
}

TEST(DirectionControl, IsRefusedWhenTheKernelTookSomethingElse) {
  driver = {.supported = SER_RS485_ENABLED, .delay = 100};
  EXPECT_EQ(set_direction_control(0, line_with(bus::Rs485::kernel), driver_io_control),
            "/dev/ttyS7: asked for RS-485 enabled, RTS on send, delays 0 and 0 ms; the driver took "
            "enabled, delays 100 and 0 ms");
}

TEST(DirectionControl, ByRtsBeginsWithReceiving) {
  driver = {};
  EXPECT_EQ(set_direction_control(0, line_with(bus::Rs485::rts), driver_io_control), std::nullopt);
  EXPECT_EQ(driver.modem_lines & TIOCM_RTS, 0);
  EXPECT_TRUE(set_rts(0, true, driver_io_control));
  EXPECT_NE(driver.modem_lines & TIOCM_RTS, 0);
}

TEST(DirectionControl, ByRtsNeedsADriverThatKnowsItsTransmitter) {
  driver = {.knows_line_status = false};
  EXPECT_EQ(set_direction_control(0, line_with(bus::Rs485::rts), driver_io_control),
            "/dev/ttyS7: rs485 = \"rts\" needs a driver that says when its transmitter is empty: "
            "Inappropriate ioctl for device");
}

TEST(Transmitter, IsEmptyWhenTheDriverSaysSo) {
  driver = {};
  EXPECT_EQ(is_transmitter_empty(0, driver_io_control), std::optional(true));
  driver.line_status = 0;
  EXPECT_EQ(is_transmitter_empty(0, driver_io_control), std::optional(false));
  driver.knows_line_status = false;
  EXPECT_EQ(is_transmitter_empty(0, driver_io_control), std::nullopt);
}

}  // namespace
}  // namespace mbgate::io

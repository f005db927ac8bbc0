// SPDX-License-Identifier: Apache-2.0
// No driver of a test machine knows RS-485: a function stands in for ioctl().
#include "io/lines/tty_direction.hpp"

#include <gtest/gtest.h>
#include <linux/serial.h>
#include <sys/ioctl.h>

#include <cerrno>
#include <chrono>

namespace mbgate::io {
namespace {

/// A driver that supports the flags it is given and drops the others, as the kernel does.
struct Driver {
  std::uint32_t supported = 0;
  std::uint32_t delay = 0;  ///< forced upon every setting
  serial_rs485 state{};     ///< at first, what the device tree says
  int settings = 0;         ///< how often it was set
  int modem_lines = TIOCM_RTS;
  unsigned line_status = TIOCSER_TEMT;
  bool knows_rs485 = true;
  bool knows_line_status = true;
};

Driver driver;

int driver_io_control(int /*fd*/, unsigned long request, void* argument) {
  switch (request) {
    case TIOCSRS485:
      ++driver.settings;
      driver.state = *static_cast<serial_rs485*>(argument);
      driver.state.flags &= driver.supported;
      if (driver.delay != 0) {
        driver.state.delay_rts_before_send = driver.delay;
      }
      return 0;
    case TIOCGRS485:
      if (!driver.knows_rs485) {
        break;
      }
      *static_cast<serial_rs485*>(argument) = driver.state;
      return 0;
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

/// What a driver has from the device tree: how its transceiver is wired, and how fast it is.
Driver driver_with(std::uint32_t flags, std::uint32_t before, std::uint32_t after) {
  Driver made{.supported = kAll};
  made.state.flags = flags;
  made.state.delay_rts_before_send = before;
  made.state.delay_rts_after_send = after;
  return made;
}

std::optional<std::string> set(const bus::LineSettings& line) {
  return set_direction_control(0, line, driver_io_control);
}

TEST(DirectionControl, ByTheKernelRaisesRtsWithoutDelaysWhereNobodySaysOtherwise) {
  driver = driver_with(0, 0, 0);
  EXPECT_EQ(set(line_with(bus::Rs485::kernel)), std::nullopt);
  EXPECT_EQ(driver.state.flags, SER_RS485_ENABLED | SER_RS485_RTS_ON_SEND);
  EXPECT_EQ(driver.state.delay_rts_before_send, 0U);
  EXPECT_EQ(driver.state.delay_rts_after_send, 0U);
}

TEST(DirectionControl, ByTheKernelKeepsPolarityAndDelaysOfTheDeviceTree) {
  driver = driver_with(SER_RS485_RTS_AFTER_SEND, 2, 7);
  EXPECT_EQ(set(line_with(bus::Rs485::kernel)), std::nullopt);
  EXPECT_EQ(driver.state.flags, SER_RS485_ENABLED | SER_RS485_RTS_AFTER_SEND);
  EXPECT_EQ(driver.state.delay_rts_before_send, 2U);
  EXPECT_EQ(driver.state.delay_rts_after_send, 7U);
}

TEST(DirectionControl, ByTheKernelKeepsTheTerminationOfTheBus) {
  driver = driver_with(SER_RS485_ENABLED | SER_RS485_RTS_ON_SEND | SER_RS485_TERMINATE_BUS, 0, 0);
  driver.supported |= SER_RS485_TERMINATE_BUS;
  EXPECT_EQ(set(line_with(bus::Rs485::kernel)), std::nullopt);
  EXPECT_EQ(driver.state.flags,
            SER_RS485_ENABLED | SER_RS485_RTS_ON_SEND | SER_RS485_TERMINATE_BUS);
}

TEST(DirectionControl, ByTheKernelDoesWhatTheKeysSay) {
  driver = driver_with(SER_RS485_RTS_AFTER_SEND, 2, 7);
  auto line = line_with(bus::Rs485::kernel);
  line.rs485_rts_on_send = true;
  line.rs485_delay_after = std::chrono::milliseconds(0);
  EXPECT_EQ(set(line), std::nullopt);
  EXPECT_EQ(driver.state.flags, SER_RS485_ENABLED | SER_RS485_RTS_ON_SEND);
  EXPECT_EQ(driver.state.delay_rts_before_send, 2U) << "no key says otherwise";
  EXPECT_EQ(driver.state.delay_rts_after_send, 0U);
  line.rs485_rts_on_send = false;
  line.rs485_delay_before = std::chrono::milliseconds(100);
  EXPECT_EQ(set(line), std::nullopt);
  EXPECT_EQ(driver.state.flags, SER_RS485_ENABLED | SER_RS485_RTS_AFTER_SEND);
  EXPECT_EQ(driver.state.delay_rts_before_send, 100U);
}

TEST(DirectionControl, ByTheKernelReceivesWhileSendingOnlyWhenTheEchoIsWanted) {
  driver = driver_with(SER_RS485_RTS_ON_SEND | SER_RS485_RX_DURING_TX, 0, 0);
  auto line = line_with(bus::Rs485::kernel);
  EXPECT_EQ(set(line), std::nullopt);
  EXPECT_EQ(driver.state.flags, SER_RS485_ENABLED | SER_RS485_RTS_ON_SEND);
  line.echo = true;
  EXPECT_EQ(set(line), std::nullopt);
  EXPECT_EQ(driver.state.flags, SER_RS485_ENABLED | SER_RS485_RTS_ON_SEND | SER_RS485_RX_DURING_TX);
}

TEST(DirectionControl, IsRefusedWhenTheKernelTookSomethingElse) {
  driver = {.supported = SER_RS485_ENABLED, .delay = 100};
  EXPECT_EQ(set(line_with(bus::Rs485::kernel)),
            "/dev/ttyS7: asked for RS-485 enabled, RTS on send, delays 0 and 0 ms; the driver took "
            "enabled, delays 100 and 0 ms");
}

TEST(DirectionControl, ByTheKernelNeedsADriverThatCanSayWhatItHas) {
  driver = driver_with(0, 0, 0);
  driver.knows_rs485 = false;
  EXPECT_EQ(
      set(line_with(bus::Rs485::kernel)),
      "/dev/ttyS7: the driver has no RS-485 mode; use rs485 = \"off\" if the adapter switches "
      "direction by itself, as most USB adapters do, or rs485 = \"rts\"");
  EXPECT_EQ(driver.settings, 0);
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

// SPDX-License-Identifier: Apache-2.0
// The shell's parts with real ptys, but with instants that the test hands in.
#include "sim/program/live_bus.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <termios.h>

#include <cstdlib>
#include <fstream>

#include "unit/sim/wire/wire_rig.hpp"

namespace mbgate::test {
namespace {

namespace fs = std::filesystem;

/// Waits until there is something to read; only a broken test waits long.
bool becomes_readable(int descriptor) {
  pollfd waiting{descriptor, POLLIN, 0};
  return ::poll(&waiting, 1, 10'000) == 1;
}

class LivePorts : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "mbgate-sim-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    link_ = folder_ / "line";
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] sim::BusSettings settings() const {
    return {
        .name = "a",
        .link = link_,
        .wire = {.baud = modbus::Baud{10000}, .chunk = 0ms, .clocking = sim::Clocking::real_time},
        .devices = {{.address = 1}}};
  }

  fs::path folder_;
  fs::path link_;
};

TEST_F(LivePorts, MakeALinkAndRemoveIt) {
  {
    const auto pty = sim::Pty::open(link_);
    ASSERT_TRUE(pty);
    EXPECT_EQ(fs::read_symlink(link_), pty->path());
  }
  EXPECT_FALSE(fs::is_symlink(link_));
}

TEST_F(LivePorts, ReplaceALinkThatLeadsNowhere) {
  fs::create_symlink(folder_ / "gone", link_);
  const auto pty = sim::Pty::open(link_);
  ASSERT_TRUE(pty);
  EXPECT_EQ(fs::read_symlink(link_), pty->path());
}

TEST_F(LivePorts, LeaveEverythingElseAlone) {
  const std::string refusal =
      "link " + link_.string() + " already exists, and is in use or not a link; remove it";
  std::ofstream(link_) << "precious";
  EXPECT_EQ(sim::Pty::open(link_).error(), refusal);
  EXPECT_EQ(fs::file_size(link_), 8U);
  fs::remove(link_);
  fs::create_symlink("/dev/null", link_);
  EXPECT_EQ(sim::Pty::open(link_).error(), refusal);
  EXPECT_EQ(fs::read_symlink(link_), "/dev/null");
}

TEST_F(LivePorts, SayWhereALinkCannotBeMade) {
  link_ = folder_ / "missing" / "line";
  EXPECT_EQ(sim::Pty::open(link_).error(),
            "link " + link_.string() + " cannot be made: No such file or directory");
}

TEST_F(LivePorts, CarryARequestAndItsAnswer) {
  sim::LiveBus bus(settings());
  ASSERT_EQ(bus.connect(), std::nullopt);
  EXPECT_EQ(bus.introduction(), "bus a " + link_.string() + " (" + bus.pty()->path() + ')');
  const sys::UniqueFd port(::open(link_.c_str(), O_RDWR | O_NOCTTY));
  const auto request = unhex(kReadStatus);
  ASSERT_EQ(::write(port.get(), request.data(), request.size()), 8);
  ASSERT_TRUE(becomes_readable(bus.pty()->descriptor()));
  bus.handle_readable(Instant(100ms));
  std::vector<std::uint8_t> answer(7);
  for (std::size_t i = 0; i < answer.size(); ++i) {
    const auto at = bus.next_event();
    if (i == 0) {
      EXPECT_EQ(at, Instant(111500us));  // the request's end and t3.5
      bus.handle_time(*at);
    }
    EXPECT_EQ(bus.next_event(), Instant(113500us + i * 1ms));
    bus.handle_time(*bus.next_event());
    ASSERT_TRUE(becomes_readable(port.get()));
    ASSERT_EQ(::read(port.get(), &answer[i], 1), 1);
  }
  EXPECT_EQ(hex(answer), kStatus);
  EXPECT_EQ(bus.counters_text(),
            "bus a: frames 1, answers 1, silence violations 0, collisions 0, bad CRC 0");
}

/// Sets the port as a client would that knows the classic rates only.
void set_port(int port, speed_t rate, bool two_stop_bits) {
  termios mode{};
  ASSERT_EQ(::tcgetattr(port, &mode), 0);
  ::cfsetspeed(&mode, rate);
  mode.c_cflag =
      two_stop_bits ? mode.c_cflag | CSTOPB : mode.c_cflag & ~static_cast<tcflag_t>(CSTOPB);
  ASSERT_EQ(::tcsetattr(port, TCSANOW, &mode), 0);
}

TEST_F(LivePorts, AnswerAtTheirOwnRateAndStopBitsOnly) {
  auto classic = settings();
  classic.wire.baud = modbus::Baud{9600};
  sim::LiveBus bus(classic);
  ASSERT_EQ(bus.connect(), std::nullopt);
  const sys::UniqueFd port(::open(link_.c_str(), O_RDWR | O_NOCTTY));
  const auto request = unhex(kReadStatus);
  std::vector<std::string> said;
  for (const auto& [rate, two_stop_bits] :
       {std::pair(B19200, false), std::pair(B9600, true), std::pair(B9600, false)}) {
    set_port(port.get(), rate, two_stop_bits);
    ASSERT_EQ(::write(port.get(), request.data(), request.size()), 8);
    ASSERT_TRUE(becomes_readable(bus.pty()->descriptor()));
    bus.handle_readable(Instant(100ms));
    while (const auto at = bus.next_event()) {
      bus.handle_time(*at);
    }
    said.push_back(bus.counters_text());
  }
  EXPECT_EQ(said,
            (std::vector<std::string>{
                "bus a: frames 1, answers 0, silence violations 0, collisions 0, bad CRC 1",
                "bus a: frames 2, answers 0, silence violations 0, collisions 0, bad CRC 2",
                "bus a: frames 3, answers 1, silence violations 0, collisions 0, bad CRC 2"}));
}

TEST_F(LivePorts, CarryAnAsciiRequestInParts) {
  auto ascii = settings();
  ascii.wire.framing = sim::Framing::ascii;
  ascii.wire.paced = false;
  sim::LiveBus bus(ascii);
  ASSERT_EQ(bus.connect(), std::nullopt);
  const sys::UniqueFd port(::open(link_.c_str(), O_RDWR | O_NOCTTY));
  for (const std::string_view part : {":0103000", "10001fa\r\n"}) {
    ASSERT_EQ(::write(port.get(), part.data(), part.size()), static_cast<ssize_t>(part.size()));
    ASSERT_TRUE(becomes_readable(bus.pty()->descriptor()));
    bus.handle_readable(Instant(100ms));
  }
  ASSERT_TRUE(becomes_readable(port.get()));
  std::string answer(15, ' ');
  ASSERT_EQ(::read(port.get(), answer.data(), answer.size()), 15);
  EXPECT_EQ(answer, ":0103020009F1\r\n");
}

TEST_F(LivePorts, VanishAndComeBackWithTheSameDrives) {
  sim::LiveBus bus(settings());
  ASSERT_EQ(bus.connect(), std::nullopt);
  bus.disconnect();
  EXPECT_EQ(bus.pty(), nullptr);
  EXPECT_FALSE(fs::is_symlink(link_));
  EXPECT_EQ(bus.introduction(), "bus a " + link_.string() + " (closed)");
  ASSERT_EQ(bus.connect(), std::nullopt);
  EXPECT_TRUE(fs::is_symlink(link_));
}

TEST_F(LivePorts, CountDamagedFrames) {
  sim::LiveBus bus(settings());
  ASSERT_EQ(bus.connect(), std::nullopt);
  const sys::UniqueFd port(::open(link_.c_str(), O_RDWR | O_NOCTTY));
  ASSERT_EQ(::write(port.get(), "\x01\x03", 2), 2);
  ASSERT_TRUE(becomes_readable(bus.pty()->descriptor()));
  bus.handle_readable(Instant(100ms));
  EXPECT_EQ(bus.next_event(), Instant(120ms));  // the silence that ends what is no request
  bus.handle_time(Instant(120ms));
  EXPECT_EQ(bus.counters_text(),
            "bus a: frames 1, answers 0, silence violations 0, collisions 0, bad CRC 1");
}

}  // namespace
}  // namespace mbgate::test

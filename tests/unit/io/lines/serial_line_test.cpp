// SPDX-License-Identifier: Apache-2.0
#include "io/lines/serial_line.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <thread>

#include "unit/io/run_until.hpp"
#include "unit/sys/pseudo_terminal.hpp"

namespace mbgate::io::serial_line_test {
namespace {

class SerialLineTest : public testing::Test, public LineEvents {
 protected:
  void line_opened(drive::BusId /*bus*/, bus::LineKind /*kind*/,
                   const std::vector<std::string>& warnings) override {
    ++opened_;
    warnings_ = warnings;
  }
  void line_bytes(drive::BusId /*bus*/, modbus::Bytes bytes) override {
    received_.append(bytes.begin(), bytes.end());
  }
  void line_unsent(drive::BusId /*bus*/, std::size_t bytes) override { unsent_.push_back(bytes); }
  void line_lost(drive::BusId /*bus*/, const std::string& why) override { lost_.push_back(why); }
  void line_closed(drive::BusId /*bus*/, const std::string& /*why*/) override { FAIL(); }

  void make_line(const std::string& path) {
    bus::LineSettings settings;
    settings.device = path;
    settings.format = {8, modbus::Parity::none, 1};
    line_.emplace(LineContext{context_, blocking_, *this}, drive::BusId{0}, settings);
  }
  bool open_line() {
    const int before = opened_;
    line_->open();
    return run_until(context_, [&] { return opened_ > before; });
  }
  bool wait_for(const std::function<bool()>& happened) { return run_until(context_, happened); }

  boost::asio::io_context context_;
  BlockingCalls blocking_{context_};
  std::optional<SerialLine> line_;
  int opened_ = 0;
  std::vector<std::string> warnings_;
  std::vector<std::string> lost_;
  std::string received_;
  std::vector<std::size_t> unsent_;
};

const std::array<std::uint8_t, 4> kFrame{1, 2, 3, 4};
const std::string kFrameText{1, 2, 3, 4};

/// A peer that sends as many bytes again as are read.
struct NeverSilent {
  std::array<std::uint8_t, 4> buffer{};
  std::vector<std::size_t> handed_over;
  int asked = 0;

  boost::system::error_code read_while_there_are(std::size_t limit) {
    return read_waiting(
        buffer,
        [&](std::span<std::uint8_t> room) {
          return static_cast<ssize_t>(std::min(room.size(), limit));
        },
        [&] {
          ++asked;
          return limit;
        },
        [&](modbus::Bytes bytes) {
          handed_over.push_back(bytes.size());
          return true;
        });
  }
};

TEST(ReadWaiting, ReadsOnceWhatFitsItsBuffer) {
  NeverSilent peer;
  EXPECT_FALSE(peer.read_while_there_are(3));
  EXPECT_EQ(peer.handed_over, std::vector<std::size_t>({3}));
  EXPECT_EQ(peer.asked, 0);
}

TEST(ReadWaiting, ReadsBehindAFullBufferWhatWasThereThen) {
  NeverSilent peer;
  EXPECT_FALSE(peer.read_while_there_are(10));
  EXPECT_EQ(peer.handed_over, std::vector<std::size_t>({4, 4, 4, 2}));
  EXPECT_EQ(peer.asked, 1);
}

// A reload may give a port to another bus, which may know it by another path.
TEST_F(SerialLineTest, WaitsUntilAnotherLineHasGivenBackItsPort) {
  const sys::PseudoTerminal terminal;
  bus::LineSettings settings;
  settings.device = terminal.path();
  const LineContext context{context_, blocking_, *this};
  SerialLine first(context, drive::BusId{0}, settings);
  settings.device.insert(1, "./");
  SerialLine second(context, drive::BusId{1}, settings);
  for (int round = 1; round <= 20; ++round) {
    first.open();
    ASSERT_TRUE(wait_for([&] { return opened_ == 2 * round - 1; }));
    first.close();
    second.open();
    ASSERT_TRUE(wait_for([&] { return opened_ == 2 * round || !lost_.empty(); }));
    ASSERT_EQ(lost_, std::vector<std::string>());
    second.close();
  }
}

TEST_F(SerialLineTest, CarriesBytesBothWays) {
  const sys::PseudoTerminal terminal;
  make_line(terminal.path());
  ASSERT_TRUE(open_line());
  EXPECT_TRUE(warnings_.empty());
  ASSERT_EQ(line_->transmit(kFrame), std::nullopt);
  std::string transmitted;
  ASSERT_TRUE(wait_for([&] {
    transmitted += terminal.read();
    return transmitted.size() >= kFrame.size();
  }));
  EXPECT_EQ(transmitted, kFrameText);
  ASSERT_TRUE(terminal.write(kFrame));
  ASSERT_TRUE(wait_for([&] { return received_.size() >= kFrame.size(); }));
  EXPECT_EQ(received_, kFrameText);
}

// A pty's driver holds nothing, but it takes only so much.
TEST_F(SerialLineTest, TellsHowMuchHasNotLeftWhereThatHasChanged) {
  const sys::PseudoTerminal terminal;
  make_line(terminal.path());
  ASSERT_TRUE(open_line());
  ASSERT_EQ(line_->transmit(kFrame), std::nullopt);
  line_->read_now();
  EXPECT_EQ(unsent_, std::vector<std::size_t>());
  const std::vector<std::uint8_t> frame(256, 0);
  for (int frames = 0; frames < 4096 && unsent_.empty(); ++frames) {
    ASSERT_EQ(line_->transmit(modbus::Bytes(frame)), std::nullopt);
    line_->read_now();
  }
  line_->read_now();
  ASSERT_EQ(unsent_.size(), 1U);
  EXPECT_GT(unsent_[0], 0U);
  EXPECT_LE(unsent_[0], frame.size());
}

// Giving a line back takes its time on a thread of its own.
TEST_F(SerialLineTest, CanBeOpenedAgainRightAfterItWasClosed) {
  const sys::PseudoTerminal terminal;
  make_line(terminal.path());
  ASSERT_TRUE(open_line());
  for (int i = 0; i < 50; ++i) {
    line_->close();
    ASSERT_TRUE(open_line());
    ASSERT_TRUE(lost_.empty()) << lost_[0];
  }
}

TEST_F(SerialLineTest, SaysWhyItCannotBeOpened) {
  make_line("/dev/serial/by-id/absent");
  line_->open();
  ASSERT_TRUE(wait_for([&] { return !lost_.empty(); }));
  EXPECT_EQ(lost_, std::vector<std::string>{
                       "cannot open /dev/serial/by-id/absent: No such file or directory"});
}

TEST_F(SerialLineTest, NoticesThatTheAdapterWasPulledOut) {
  sys::PseudoTerminal terminal;
  make_line(terminal.path());
  ASSERT_TRUE(open_line());
  terminal.unplug();
  ASSERT_TRUE(wait_for([&] { return !lost_.empty(); }));
  EXPECT_EQ(lost_, std::vector<std::string>{terminal.path() + ": the device has gone"});
}

TEST_F(SerialLineTest, FollowsItsPathToAnotherDevice) {
  const auto link =
      std::filesystem::temp_directory_path() / ("mbgate-line-" + std::to_string(::getpid()));
  std::filesystem::remove(link);
  auto first = std::make_unique<sys::PseudoTerminal>();
  std::filesystem::create_symlink(first->path(), link);
  make_line(link.string());
  ASSERT_TRUE(open_line());
  const sys::PseudoTerminal second;
  first->unplug();
  ASSERT_TRUE(wait_for([&] { return lost_.size() == 1; }));
  std::filesystem::remove(link);
  std::filesystem::create_symlink(second.path(), link);
  ASSERT_TRUE(open_line());
  std::filesystem::remove(link);
  ASSERT_TRUE(second.write(kFrame));
  EXPECT_TRUE(wait_for([&] { return received_ == kFrameText; }));
}

TEST_F(SerialLineTest, FinishesAFrameThatTheDriverTakesInParts) {
  const sys::PseudoTerminal terminal;
  make_line(terminal.path());
  ASSERT_TRUE(open_line());
  const std::vector<std::uint8_t> frame(modbus::kMaxRtuSize, 0x55);
  // Until the pseudo-terminal is full; the frame in which that happens is still whole, the next one
  // is refused.
  std::optional<std::string> error;
  std::size_t frames = 0;
  while (!error && frames < 10000) {
    error = line_->transmit(frame);
    ++frames;
  }
  EXPECT_EQ(error, terminal.path() + ": the previous frame is still not transmitted");
  EXPECT_TRUE(lost_.empty());
}

/// Another holder of a line fills it up, so that no byte of ours is taken; nothing if only root may
/// do that. The kernel moves bytes from the buffer of the line to that of its reader on its own
/// time and so makes room again: the line is full when both have taken nothing for a while, and the
/// reader's has no room.
std::optional<std::size_t> fill(const sys::PseudoTerminal& terminal) {
  const sys::UniqueFd filler(
      ::open(terminal.path().c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!filler.is_open()) {
    return std::nullopt;
  }
  constexpr int kRefusals = 20;
  constexpr std::size_t kReadersRoom = 4095;  // N_TTY_BUF_SIZE less one
  std::size_t filled = 0;
  const std::array<char, 1024> filling{};
  for (int refused = 0; refused < kRefusals || terminal.waiting() < kReadersRoom;) {
    const ssize_t count = ::write(filler.get(), filling.data(), filling.size());
    if (count > 0) {
      filled += static_cast<std::size_t>(count);
      refused = 0;
    } else {
      ++refused;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  return filled;
}

constexpr auto kSkipped = "skipped: only root can open a line in exclusive use again";

TEST_F(SerialLineTest, WritesTheRestAsSoonAsTheDriverTakesIt) {
  const sys::PseudoTerminal terminal;
  make_line(terminal.path());
  ASSERT_TRUE(open_line());
  const auto filled = fill(terminal);
  if (!filled) {
    GTEST_SKIP() << kSkipped;
  }
  ASSERT_EQ(line_->transmit(kFrame), std::nullopt);
  std::string transmitted;
  ASSERT_TRUE(wait_for([&] {
    for (auto piece = terminal.read(); !piece.empty(); piece = terminal.read()) {
      transmitted += piece;
    }
    return transmitted.size() == *filled + kFrame.size();
  }));
  EXPECT_EQ(transmitted.substr(*filled), kFrameText);
  EXPECT_EQ(line_->transmit(kFrame), std::nullopt);
}

TEST_F(SerialLineTest, ThrowsAFrameAwayThatTheDriverDoesNotTakeInTime) {
  const sys::PseudoTerminal terminal;
  make_line(terminal.path());
  ASSERT_TRUE(open_line());
  if (!fill(terminal)) {
    GTEST_SKIP() << kSkipped;
  }
  ASSERT_EQ(line_->transmit(kFrame), std::nullopt);
  ASSERT_TRUE(wait_for([&] { return !lost_.empty(); }));
  EXPECT_EQ(lost_[0], terminal.path() + ": the driver does not take a frame in time");
}

TEST_F(SerialLineTest, ReportsNothingOnceItWasClosedWhileOpening) {
  const sys::PseudoTerminal terminal;
  make_line(terminal.path());
  line_->open();
  line_->close();
  // The first opening may hold the line for a moment still, and the next one fails.
  ASSERT_TRUE(wait_for([&] {
    line_->open();
    return opened_ > 0;
  }));
  EXPECT_EQ(opened_, 1);
  ASSERT_TRUE(terminal.write(kFrame));
  EXPECT_TRUE(wait_for([&] { return received_ == kFrameText; }));
}

TEST_F(SerialLineTest, DoesNotTransmitWhileClosed) {
  make_line("/dev/serial/by-id/absent");
  EXPECT_EQ(line_->transmit(kFrame), "/dev/serial/by-id/absent: the line is not open");
}

}  // namespace
}  // namespace mbgate::io::serial_line_test

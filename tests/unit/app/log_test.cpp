// SPDX-License-Identifier: Apache-2.0
#include "app/log.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <csignal>

#include "io/unique_fd.hpp"

namespace mbgate::app {
namespace {

constexpr std::chrono::seconds kLimit{60};

/// A pipe that a log writes to.
class LogTest : public testing::Test {
 protected:
  void SetUp() override {
    std::signal(SIGPIPE, SIG_IGN);  // as mbgated does
    std::array<int, 2> ends{};
    ASSERT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
    read_end_.reset(ends[0]);
    write_end_.reset(ends[1]);
  }
  std::string written() {
    std::string text(65536, '\0');
    const ssize_t count = ::read(read_end_.get(), text.data(), text.size());
    text.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    return text;
  }

  io::UniqueFd read_end_;
  io::UniqueFd write_end_;
};

TEST(LogLine, BeginsWithAWordForPeople) {
  EXPECT_EQ(log_line(Level::error, "text", false), "error: text");
  EXPECT_EQ(log_line(Level::warning, "text", false), "warning: text");
  EXPECT_EQ(log_line(Level::notice, "text", false), "notice: text");
  EXPECT_EQ(log_line(Level::info, "text", false), "info: text");
}

TEST(LogLine, BeginsWithThePriorityForTheJournal) {
  EXPECT_EQ(log_line(Level::error, "text", true), "<3>text");
  EXPECT_EQ(log_line(Level::info, "text", true), "<6>text");
}

TEST_F(LogTest, WritesLinesInOrder) {
  Log log(false, write_end_.get());
  log.print("listening plant 127.0.0.1:502");
  log.write(Level::notice, "bus line-a is open");
  ASSERT_TRUE(log.flush(kLimit));
  EXPECT_EQ(written(), "listening plant 127.0.0.1:502\nnotice: bus line-a is open\n");
}

TEST_F(LogTest, SaysOnceThatLinesOfOneKindAreOnlyCounted) {
  Log log(false, write_end_.get());
  for (int i = 1; i <= 12; ++i) {
    log.write_limited(Level::warning, "refused", "client " + std::to_string(i));
  }
  ASSERT_TRUE(log.flush(kLimit));
  const std::string text = written();
  const std::string end =
      "warning: client 9\n"
      "warning: client 10 (more of this kind within a minute are only counted)\n";
  ASSERT_GE(text.size(), end.size());
  EXPECT_EQ(text.substr(text.size() - end.size()), end);
}

TEST_F(LogTest, TellsItsObserverOfEveryLine) {
  Log log(false, write_end_.get());
  std::string told;
  log.write(Level::info, "before");
  log.observe([&](Level level, const std::string& text) {
    told += std::string(level_word(level)) + " " + text + "\n";
  });
  log.print("listening plant 127.0.0.1:502");
  log.write(Level::notice, "bus line-a is open");
  for (int i = 1; i <= 11; ++i) {
    log.write_limited(Level::warning, "refused", "client " + std::to_string(i));
  }
  log.observe({});
  log.write(Level::info, "after");
  EXPECT_TRUE(told.starts_with("info listening plant 127.0.0.1:502\nnotice bus line-a is open\n"))
      << told;
  EXPECT_TRUE(
      told.ends_with("warning client 10 (more of this kind within a minute are only counted)\n"))
      << told;
}

TEST_F(LogTest, TellsItsObserverNothingOfLinesThatAreNotWritten) {
  ASSERT_GT(::fcntl(write_end_.get(), F_SETPIPE_SZ, 4096), 0);
  Log log(false, write_end_.get());
  int told = 0;
  log.observe([&](Level, const std::string&) { ++told; });
  for (int i = 0; i < 3000; ++i) {
    log.print(std::string(100, 'x'));
  }
  EXPECT_GE(told, 1000);
  EXPECT_LT(told, 3000);
  read_end_.reset();  // the writer gets an error instead of waiting
}

TEST_F(LogTest, DoesNotBlockWhenNobodyReads) {
  ASSERT_GT(::fcntl(write_end_.get(), F_SETPIPE_SZ, 4096), 0);
  Log log(false, write_end_.get());
  for (int i = 0; i < 3000; ++i) {
    log.print(std::string(100, 'x'));
  }
  EXPECT_FALSE(log.flush(std::chrono::milliseconds(1)));
  read_end_.reset();  // the writer gets an error instead of waiting
}

}  // namespace
}  // namespace mbgate::app

// SPDX-License-Identifier: Apache-2.0
#include "app/log.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <future>

#include "sys/unique_fd.hpp"

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

  sys::UniqueFd read_end_;
  sys::UniqueFd write_end_;
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

// What is written however often it comes would take the room of all else from those who read along.
TEST_F(LogTest, HasLinesForTheJournalAlone) {
  Log log(false, write_end_.get());
  int told = 0;
  log.observe([&](Level, const std::string&) { ++told; });
  for (int i = 0; i < 30; ++i) {
    log.write_unobserved(Level::notice, "write " + std::to_string(i));
  }
  ASSERT_TRUE(log.flush(kLimit));
  EXPECT_EQ(told, 0);
  EXPECT_EQ(std::ranges::count(written(), '\n'), 30);
}

TEST_F(LogTest, SendsEntriesToTheJournal) {
  std::vector<std::vector<std::string>> sent;
  Log log(true, write_end_.get(), [&](const std::vector<std::string>& fields) {
    sent.push_back(fields);
    return true;
  });
  log.print("listening plant 127.0.0.1:502", {.id = {"0011"}, .listener = "plant"});
  log.write(Level::notice, "bus line-a is open", {.bus = "line-a"});
  log.write_limited(Level::warning, "refused", "client refused", {.client = "192.168.10.5"});
  ASSERT_TRUE(log.flush(kLimit));
  const std::string identifier = "SYSLOG_IDENTIFIER=mbgated";
  const std::string facility = "SYSLOG_FACILITY=3";
  EXPECT_EQ(
      sent,
      (std::vector<std::vector<std::string>>{
          {"MESSAGE=listening plant 127.0.0.1:502", "PRIORITY=6", identifier, facility,
           "MESSAGE_ID=0011", "MBGATE_LISTENER=plant"},
          {"MESSAGE=bus line-a is open", "PRIORITY=5", identifier, facility, "MBGATE_BUS=line-a"},
          {"MESSAGE=client refused", "PRIORITY=4", identifier, facility,
           "MBGATE_CLIENT=192.168.10.5"}}));
  write_end_.reset();
  EXPECT_EQ(written(), "");
}

TEST_F(LogTest, WritesToStandardErrorWhatTheJournalDoesNotTake) {
  Log log(true, write_end_.get(), [](const std::vector<std::string>&) { return false; });
  log.write(Level::warning, "bus line-a is lost", {.bus = "line-a"});
  log.print("listening plant 127.0.0.1:502");
  ASSERT_TRUE(log.flush(kLimit));
  EXPECT_EQ(written(), "<4>bus line-a is lost\nlistening plant 127.0.0.1:502\n");
}

TEST_F(LogTest, CountsWhatAJournalThatBlocksDoesNotTake) {
  std::promise<void> opened;
  const auto open = opened.get_future().share();
  std::vector<std::string> sent;
  Log log(true, write_end_.get(), [&, open](const std::vector<std::string>& fields) {
    open.wait();
    sent.push_back(fields.front());
    return true;
  });
  for (int i = 0; i < 1500; ++i) {
    log.write(Level::notice, "line");
  }
  EXPECT_FALSE(log.flush(std::chrono::milliseconds(1)));
  opened.set_value();
  ASSERT_TRUE(log.flush(kLimit));
  EXPECT_EQ(sent.size(), 1000U);
  log.write(Level::notice, "last");
  ASSERT_TRUE(log.flush(kLimit));
  EXPECT_EQ(
      std::vector(sent.begin() + 1000, sent.end()),
      (std::vector<std::string>{
          "MESSAGE=last",
          "MESSAGE=500 lines are missing here: the journal did not accept them fast enough"}));
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

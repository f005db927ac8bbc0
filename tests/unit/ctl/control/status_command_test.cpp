// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <sstream>

#include "ctl/request/carry_out.hpp"
#include "ctl/request/repetition.hpp"

namespace mbgate::ctl {
namespace {

using namespace std::chrono_literals;

/// Where no mbgated is.
StatusCommand watch_of_nobody(std::size_t times) {
  StatusCommand command;
  command.socket = "/no-such-folder/control";
  command.every = 10ms;
  command.times = times;
  return command;
}

TEST(Watch, GoesOnWhereNobodyAnswers) {
  std::ostringstream out;
  std::ostringstream errors;
  EXPECT_EQ(run(watch_of_nobody(2), out, errors), 1);
  EXPECT_EQ(out.str(), "");
  EXPECT_THAT(errors.str(),
              testing::MatchesRegex("[0-9:.]+\nmbgatectl: there is no control socket at [^\n]*\n"
                                    "[0-9:.]+\nmbgatectl: there is no control socket at [^\n]*\n"));
}

TEST(Watch, PrintsOneJsonObjectALine) {
  auto command = watch_of_nobody(2);
  command.json = true;
  command.on_terminal = true;  // a screen is for people
  std::ostringstream out;
  std::ostringstream errors;
  EXPECT_EQ(run(command, out, errors), 1);
  EXPECT_EQ(errors.str(), "");
  EXPECT_THAT(out.str(), testing::MatchesRegex("[{]\"error\":\"there is no control [^\n]*\"[}]\n"
                                               "[{]\"error\":\"there is no control [^\n]*\"[}]\n"));
}

TEST(Watch, EndsWellWhenItIsInterrupted) {
  const Interruption held_back;  // the signal waits for the watch, which takes it
  raise(SIGTERM);
  std::ostringstream out;
  std::ostringstream errors;
  EXPECT_EQ(run(watch_of_nobody(1000), out, errors), 0);
}

}  // namespace
}  // namespace mbgate::ctl

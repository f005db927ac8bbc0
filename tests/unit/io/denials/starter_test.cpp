// SPDX-License-Identifier: Apache-2.0
#include "io/denials/starter.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

namespace mbgate::io {
namespace {

class StarterTest : public testing::Test {
 protected:
  StarterTest() { ::unsetenv("MANAGERPID"); }
  void TearDown() override {
    ::unsetenv("SYSTEMD_EXEC_PID");
    ::unsetenv("MANAGERPID");
  }
};

TEST_F(StarterTest, IsSomebodyWithoutSystemd) {
  ::unsetenv("SYSTEMD_EXEC_PID");
  EXPECT_EQ(starter(), Starter::somebody);
}

TEST_F(StarterTest, IsSystemdForTheProcessOfTheUnitAndNotForItsChildren) {
  ::setenv("SYSTEMD_EXEC_PID", std::to_string(::getpid()).c_str(), 1);
  EXPECT_EQ(starter(), Starter::systemd);
  ::setenv("SYSTEMD_EXEC_PID", std::to_string(::getppid()).c_str(), 1);
  EXPECT_EQ(starter(), Starter::somebody);
}

// What the messages advise is for the machine's own services.
TEST_F(StarterTest, IsSomebodyForAServiceOfAUser) {
  ::setenv("SYSTEMD_EXEC_PID", std::to_string(::getpid()).c_str(), 1);
  ::setenv("MANAGERPID", "812", 1);
  EXPECT_EQ(starter(), Starter::somebody);
}

}  // namespace
}  // namespace mbgate::io

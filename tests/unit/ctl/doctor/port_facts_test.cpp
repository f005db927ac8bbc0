// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>

#include "ctl/doctor/findings.hpp"

namespace mbgate::ctl {
namespace {

TEST(PortFacts, NameTheProcessThatHasThePortOpen) {
  const int line = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  ASSERT_EQ(::grantpt(line), 0);
  ASSERT_EQ(::unlockpt(line), 0);
  const std::string port = ::ptsname(line);
  std::array<int, 2> opened{};
  std::array<int, 2> over{};
  ASSERT_EQ(::pipe(opened.data()), 0);
  ASSERT_EQ(::pipe(over.data()), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(over[1]);
    char byte = ::open(port.c_str(), O_RDWR | O_NOCTTY) >= 0 ? 'y' : 'n';
    const bool told = ::write(opened[1], &byte, 1) == 1;
    const bool ended = ::read(over[0], &byte, 1) == 0;
    _exit(told && ended ? 0 : 1);
  }
  char byte = 'n';
  EXPECT_EQ(::read(opened[0], &byte, 1), 1);
  EXPECT_EQ(byte, 'y');
  const auto holders = find_holders(port);
  EXPECT_TRUE(
      std::ranges::any_of(holders, [&](const Holder& holder) { return holder.process == child; }));
  for (const int end : {over[0], over[1], opened[0], opened[1], line}) {
    ::close(end);
  }
  int status = 1;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
}

}  // namespace
}  // namespace mbgate::ctl

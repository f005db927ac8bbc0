// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "sys/unique_fd.hpp"

namespace mbgate::sys {
namespace {

/// The number that the next file gets where standard output and standard error were closed.
int next_number() {
  ::close(STDOUT_FILENO);
  ::close(STDERR_FILENO);
  open_standard_streams();
  return ::open("/", O_RDONLY);
}

TEST(StandardStreams, LeaveTheirNumbersToNoOtherFile) {
  EXPECT_EXIT(::_exit(next_number() > STDERR_FILENO ? 0 : 1), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace mbgate::sys

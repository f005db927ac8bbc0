// SPDX-License-Identifier: Apache-2.0
// A pseudo-terminal for tests: what is at its other end is the test.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

namespace mbgate::ctl {

class Terminal {
 public:
  Terminal() : other_end_(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    EXPECT_EQ(grantpt(other_end_), 0);
    EXPECT_EQ(unlockpt(other_end_), 0);
    path = ptsname(other_end_);
    // Else a read at the other end fails while nobody has the port open.
    kept_open_ = open(path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    EXPECT_GE(kept_open_, 0);
  }
  ~Terminal() {
    close(kept_open_);
    close(other_end_);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  [[nodiscard]] int other_end() const { return other_end_; }

  std::string path;

 private:
  int other_end_;
  int kept_open_ = -1;
};

}  // namespace mbgate::ctl

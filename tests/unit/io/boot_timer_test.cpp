// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "io/clock.hpp"
#include "unit/io/run_until.hpp"

namespace mbgate::io {
namespace {

using namespace std::chrono_literals;

bus::Instant of(clockid_t clock) {
  timespec at{};
  ::clock_gettime(clock, &at);
  return bus::Instant(std::chrono::seconds(at.tv_sec) + std::chrono::nanoseconds(at.tv_nsec));
}

TEST(Clock, GoesOnWhileTheComputerIsSuspended) {
  const bus::Instant before = of(CLOCK_BOOTTIME);
  const bus::Instant at = now();
  EXPECT_LE(before, at);
  EXPECT_LE(at, of(CLOCK_BOOTTIME));
}

/// The clocks of all timers of the process, as the kernel numbers them.
std::string clocks_of_timers() {
  std::string clocks;
  for (const auto& descriptor : std::filesystem::directory_iterator("/proc/self/fdinfo")) {
    std::ifstream file(descriptor.path());
    std::string word;
    while (file >> word) {
      if (word == "clockid:" && file >> word) {
        clocks += word + ' ';
      }
    }
  }
  return clocks;
}

TEST(BootTimer, CountsTheClockThatGoesOn) {
  boost::asio::io_context context;
  const std::string clock = std::to_string(CLOCK_BOOTTIME) + ' ';
  EXPECT_EQ(clocks_of_timers().find(clock), std::string::npos);
  const BootTimer timer(context, [] {});
  EXPECT_NE(clocks_of_timers().find(clock), std::string::npos);
}

TEST(BootTimer, RingsOnceEachTimeItIsSet) {
  boost::asio::io_context context;
  int rings = 0;
  BootTimer timer(context, [&] { ++rings; });
  for (const bus::Duration after : {bus::Duration(1ms), bus::Duration(0), bus::Duration(-1s)}) {
    const int before = rings;
    timer.set(after);
    ASSERT_TRUE(run_until(context, [&] { return rings == before + 1; }));
    context.restart();
    EXPECT_EQ(context.run(), 0U);  // nothing is left to wait for
  }
}

TEST(BootTimer, MayBeSetToEarlierAndAgainFromItsRing) {
  boost::asio::io_context context;
  int rings = 0;
  BootTimer* again = nullptr;
  BootTimer timer(context, [&] {
    if (++rings < 3) {
      again->set(1ms);
    }
  });
  again = &timer;
  timer.set(1h);
  timer.set(1ms);
  ASSERT_TRUE(run_until(context, [&] { return rings == 3; }));
}

}  // namespace
}  // namespace mbgate::io

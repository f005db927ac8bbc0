// SPDX-License-Identifier: Apache-2.0
#include "io/memory_left.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

namespace mbgate::io {
namespace {

// Its limits are those of a test of the built programs: here they would end the sanitizers.
TEST(MemoryLeft, IsThereWithoutALimit) {
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &limit), 0);
  if (limit.rlim_cur != RLIM_INFINITY) {
    GTEST_SKIP() << "the address space is limited";
  }
  EXPECT_TRUE(is_memory_left());
}

}  // namespace
}  // namespace mbgate::io

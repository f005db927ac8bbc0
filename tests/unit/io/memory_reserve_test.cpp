// SPDX-License-Identifier: Apache-2.0
#include "io/memory_reserve.hpp"

#include <gtest/gtest.h>

#include <new>

namespace mbgate::io {
namespace {

// As operator new does with an allocation that is refused: it calls the handler and tries again.
TEST(MemoryReserve, IsGivenUpPieceByPieceForAllocationsThatAreRefusedAndTakenBack) {
  keep_memory_reserve();
  EXPECT_TRUE(is_memory_left());
  const std::new_handler handler = std::get_new_handler();
  ASSERT_NE(handler, nullptr);
  std::size_t given = 0;
  const auto give_all = [&] {
    while (true) {
      handler();
      ++given;
    }
  };
  EXPECT_THROW(give_all(), std::bad_alloc);  // then the allocation fails
  EXPECT_GT(given, 1U);
  EXPECT_TRUE(is_memory_left());  // there is enough again
  EXPECT_NO_THROW(handler());
}

}  // namespace
}  // namespace mbgate::io

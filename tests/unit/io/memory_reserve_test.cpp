// SPDX-License-Identifier: Apache-2.0
#include "io/memory_reserve.hpp"

#include <gtest/gtest.h>

#include <new>

namespace mbgate::io {
namespace {

// As operator new does with an allocation that is refused: it calls the handler and tries again.
TEST(MemoryReserve, IsGivenUpOnceForAnAllocationThatIsRefusedAndTakenBack) {
  keep_memory_reserve();
  const std::new_handler handler = std::get_new_handler();
  ASSERT_NE(handler, nullptr);
  EXPECT_TRUE(is_memory_left());
  EXPECT_NO_THROW(handler());
  EXPECT_THROW(handler(), std::bad_alloc);  // and then the allocation fails
  EXPECT_TRUE(is_memory_left());            // there is enough again
  EXPECT_NO_THROW(handler());
}

}  // namespace
}  // namespace mbgate::io

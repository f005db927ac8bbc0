// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "ctl/trace/trace_printer.hpp"

namespace mbgate::ctl {
namespace {

TEST(TraceQuery, HasNothingWithoutAFilter) { EXPECT_EQ(trace_target({}), "/api/v1/trace"); }

TEST(TraceQuery, HasEveryFilter) {
  EXPECT_EQ(trace_target({"line-a", "axis_x.1", "192.0.2.7", 16, true}),
            "/api/v1/trace?bus=line-a&device=axis_x.1&client=192.0.2.7&function=16&only=failed");
}

TEST(TraceQuery, EncodesWhatAQueryCannotHave) {
  EXPECT_EQ(trace_target({"Förderband 1 & 2", "a=b+c%#?", "fd00::5", {}, false}),
            "/api/v1/trace?bus=F%C3%B6rderband%201%20%26%202&device=a%3Db%2Bc%25%23%3F"
            "&client=fd00%3A%3A5");
}

}  // namespace
}  // namespace mbgate::ctl

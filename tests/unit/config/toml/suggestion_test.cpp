// SPDX-License-Identifier: Apache-2.0
#include "config/toml/suggestion.hpp"

#include <gtest/gtest.h>

namespace mbgate::config {
namespace {

TEST(EditDistance, CountsEachKindOfSlipOnce) {
  EXPECT_EQ(edit_distance("baud", "baud"), 0U);
  EXPECT_EQ(edit_distance("baud", "bauds"), 1U);
  EXPECT_EQ(edit_distance("baud", "bud"), 1U);
  EXPECT_EQ(edit_distance("baud", "bawd"), 1U);
  EXPECT_EQ(edit_distance("baud", "buad"), 1U);
  EXPECT_EQ(edit_distance("", "echo"), 4U);
  EXPECT_EQ(edit_distance("echo", ""), 4U);
}

TEST(DidYouMean, NamesTheNearestWord) {
  const std::vector<std::string_view> keys = {"response_wait", "response_timeout", "retries"};
  EXPECT_EQ(did_you_mean("respose_timeuot", keys), "; did you mean 'response_timeout'?");
  EXPECT_EQ(did_you_mean("retrys", keys), "; did you mean 'retries'?");
}

TEST(DidYouMean, SaysNothingWhereNothingIsNear) {
  EXPECT_EQ(did_you_mean("colour", {"baud", "echo", ""}), "");
  EXPECT_EQ(did_you_mean("x", {"y", "xy", "unit"}), "");
  EXPECT_EQ(did_you_mean("", {"a", "unit"}), "");
  EXPECT_EQ(did_you_mean("baud", {}), "");
}

TEST(DidYouMean, SparesItselfEndlessWords) {
  EXPECT_EQ(did_you_mean(std::string(100'000, 'a'), {std::string_view("baud")}), "");
}

}  // namespace
}  // namespace mbgate::config

// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "app/text.hpp"

namespace mbgate::app {
namespace {

TEST(ValidUtf8, IsLeftAsItIs) {
  for (const auto* text : {"", "axis-x", "K\xC3\xA4se", "\xE2\x82\xAC", "\xF0\x9F\x98\x80"}) {
    EXPECT_EQ(valid_utf8(text), text);
  }
}

TEST(ValidUtf8, IsMadeOfWhatIsNot) {
  EXPECT_EQ(valid_utf8("k\xE4se"), "k\xEF\xBF\xBDse");
  EXPECT_EQ(valid_utf8("cut \xE2\x82"), "cut \xEF\xBF\xBD\xEF\xBF\xBD");
  EXPECT_EQ(valid_utf8("\xC0\x80"), "\xEF\xBF\xBD\xEF\xBF\xBD");  // too long
  EXPECT_EQ(valid_utf8("\xED\xA0\x80").size(), 9U);               // a surrogate
  EXPECT_EQ(valid_utf8("\xF4\x90\x80\x80").size(), 12U);          // beyond U+10FFFF
}

}  // namespace
}  // namespace mbgate::app

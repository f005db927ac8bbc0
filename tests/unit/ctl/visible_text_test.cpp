// SPDX-License-Identifier: Apache-2.0
#include "ctl/visible_text.hpp"

#include <gtest/gtest.h>

namespace mbgate::ctl {
namespace {

TEST(VisibleText, LeavesWhatIsOnlyRead) {
  for (const std::string_view text :
       {"", "axis-x: does not answer any more", "Achse 1: läuft", "轴", "\U0001F600", "~ \u00A0"}) {
    EXPECT_EQ(visible_text(text), text);
  }
}

TEST(VisibleText, ShowsEveryControlCharacter) {
  for (unsigned code = 0; code < 0x20; ++code) {
    std::string expected = "a\\u00";
    expected += "01"[code / 16];
    expected += "0123456789ABCDEF"[code % 16];
    EXPECT_EQ(visible_text(std::string{'a', static_cast<char>(code), 'b'}), expected + "b");
  }
  EXPECT_EQ(visible_text("\x7F"), "\\u007F");
  EXPECT_EQ(visible_text("\u0080\u009B31m\u009F"), "\\u0080\\u009B31m\\u009F");
  EXPECT_EQ(visible_text("\u202Eexe.\u2066\u2028"), "\\u202Eexe.\\u2066\\u2028");
}

TEST(VisibleText, ShowsBytesThatAreNoUtf8) {
  EXPECT_EQ(visible_text("\x9B"
                         "31m"),
            "\\u009B31m");
  EXPECT_EQ(visible_text("\xC2"), "\\u00C2");               // nothing behind it
  EXPECT_EQ(visible_text("\xC2\x1B["), "\\u00C2\\u001B[");  // it does not hide what follows
  EXPECT_EQ(visible_text("\xC0\x9B"), "\\u00C0\\u009B");    // in two bytes instead of one
  EXPECT_EQ(visible_text("\xE0\x82\x9B"), "\\u00E0\\u0082\\u009B");  // in three instead of two
  EXPECT_EQ(visible_text("\xED\xA0\x80"), "\\u00ED\\u00A0\\u0080");  // half a character of UTF-16
  EXPECT_EQ(visible_text("\xF4\x90\x80\x80"), "\\u00F4\\u0090\\u0080\\u0080");  // beyond the last
  EXPECT_EQ(visible_text("\xF8\x88\x80\x80\x80"), "\\u00F8\\u0088\\u0080\\u0080\\u0080");
  EXPECT_EQ(visible_text("\xFF"), "\\u00FF");
}

TEST(VisibleText, KeepsWhatItIsToKeep) {
  EXPECT_EQ(visible_text("a\n\tb\x1B\r", "\n\t"), "a\n\tb\\u001B\\u000D");
}

}  // namespace
}  // namespace mbgate::ctl

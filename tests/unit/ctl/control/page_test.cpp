// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "ctl/control/status_text.hpp"

namespace mbgate::ctl {
namespace {

using Lines = std::vector<std::string>;

TEST(Page, ShowsATextThatFitsAsItIs) {
  EXPECT_EQ(page("one\n\n  two\n", 3, 5), (Lines{"one", "", "  two"}));
  EXPECT_EQ(page("", 3, 5), Lines{});
}

TEST(Page, CutsTheRowsOfATable) {
  EXPECT_EQ(page("BUS     LOAD\nline-a  41 %\n", 10, 9), (Lines{"BUS     L", "line-a  4"}));
}

TEST(Page, FoldsSentencesAtTheirBlanks) {
  EXPECT_EQ(page("its power; its wires", 10, 10), (Lines{"its power;", "  its", "  wires"}));
  EXPECT_EQ(page("    look at: its power; its wires\n", 10, 24),
            (Lines{"    look at: its power;", "      its wires"}));
}

TEST(Page, CutsAWordThatIsLongerThanALine) {
  EXPECT_EQ(page("/run/mbgate/control", 10, 8), (Lines{"/run/mbg", "  ate/co", "  ntrol"}));
  EXPECT_EQ(page("abc", 10, 1), (Lines{"a", "b", "c"}));
  EXPECT_EQ(page("   a", 10, 2), (Lines{"  ", " a"}));
}

TEST(Page, SaysHowManyLinesAreLeftOut) {
  EXPECT_EQ(page("1\n2\n3\n4\n", 4, 80), (Lines{"1", "2", "3", "4"}));
  EXPECT_EQ(page("1\n2\n3\n4\n", 3, 80),
            (Lines{"1", "2", "... 2 more lines: the window is too small for them"}));
  EXPECT_EQ(page("1\n2\n3\n4\n", 1, 5), Lines{"... 4"});
}

TEST(Page, TakesNoWindowForNothing) {
  EXPECT_EQ(page("text", 0, 80), Lines{});
  EXPECT_EQ(page("text", 24, 0), Lines{});
}

TEST(Page, CountsCharactersAndNotBytes) {
  EXPECT_EQ(page("pr\u00FCf  stand", 1, 4), Lines{"pr\u00FCf"});
  EXPECT_EQ(page("\u00FC\u00FC\u00FC", 10, 2), (Lines{"\u00FC\u00FC", "\u00FC"}));
}

TEST(Page, LetsNothingMoveTheCursor) {
  EXPECT_EQ(page("a\x1B[2Jb\tc\x7F\n", 1, 80), Lines{"a?[2Jb?c?"});
}

}  // namespace
}  // namespace mbgate::ctl

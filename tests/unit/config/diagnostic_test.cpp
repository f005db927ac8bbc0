// SPDX-License-Identifier: Apache-2.0
#include "config/diagnostic.hpp"

#include <gtest/gtest.h>

namespace mbgate::config {
namespace {

TEST(Diagnostic, ShowsPlaceLineAndCaret) {
  EXPECT_EQ(
      render(Diagnostic{Severity::error, "x.toml", {12, 8}, "baud: wrong", "baud = \"fast\""}),
      "x.toml:12:8: error: baud: wrong\n"
      "baud = \"fast\"\n"
      "       ^\n");
}

TEST(Diagnostic, KeepsTabsSoThatTheCaretStandsRight) {
  EXPECT_EQ(render(Diagnostic{Severity::warning, "x.toml", {1, 9}, "m", "\tbaud\t= 7"}),
            "x.toml:1:9: warning: m\n\tbaud\t= 7\n\t    \t  ^\n");
}

TEST(Diagnostic, CountsCharactersNotBytes) {
  EXPECT_EQ(render(Diagnostic{Severity::error, "x.toml", {1, 5}, "m", "\xC3\xA4\xE2\x82\xAC = 7"}),
            "x.toml:1:5: error: m\n\xC3\xA4\xE2\x82\xAC = 7\n    ^\n");
}

TEST(Diagnostic, PutsTheCaretBehindTheLineAtMost) {
  EXPECT_EQ(render(Diagnostic{Severity::error, "x.toml", {1, 99}, "m", "a ="}),
            "x.toml:1:99: error: m\na =\n   ^\n");
}

TEST(Diagnostic, LetsNoControlCharacterReachTheTerminal) {
  EXPECT_EQ(render(Diagnostic{Severity::error, "x.toml", {1, 1}, "m", "a\x1B[2J"}),
            "x.toml:1:1: error: m\na [2J\n^\n");
}

TEST(Diagnostic, OfTheWholeFileHasNoLine) {
  EXPECT_EQ(render(Diagnostic{Severity::error, "x.toml", {}, "cannot be read", ""}),
            "x.toml: error: cannot be read\n");
}

TEST(Diagnostics, FailWithOneErrorAmongWarnings) {
  const Diagnostic error{Severity::error, "f", {}, "e", ""};
  const Diagnostic warning{Severity::warning, "f", {}, "w", ""};
  EXPECT_FALSE(has_errors({}));
  EXPECT_FALSE(has_errors({warning, warning}));
  EXPECT_TRUE(has_errors({warning, error}));
  EXPECT_EQ(render(std::vector{warning, error}), "f: warning: w\nf: error: e\n");
}

}  // namespace
}  // namespace mbgate::config

// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "ctl/doctor/findings.hpp"

namespace mbgate::ctl {
namespace {

TEST(FindingLine, SaysWhatWasSeenAndWhatToDo) {
  EXPECT_EQ(finding_line({Judgement::ok, "port", "it is there"}), "ok       port: it is there");
  EXPECT_EQ(finding_line({Judgement::fault, "holder", "it is held", "end it first"}),
            "fault    holder: it is held; end it first");
  EXPECT_EQ(finding_line({Judgement::unknown, "answers", "nobody was asked"}),
            "unknown  answers: nobody was asked");
}

TEST(FindingsJson, HasAdviceAndErrorOnlyWhereThereIsOne) {
  EXPECT_EQ(findings_json("a", {{Judgement::ok, "port", "is there"}}, std::nullopt),
            R"({"device":"a","findings":[{"verdict":"ok","step":"port","seen":"is there"}]})");
  EXPECT_EQ(findings_json("a", {{Judgement::unknown, "port", "s", "look"}}, "interrupted"),
            R"({"device":"a","findings":[{"verdict":"unknown","step":"port","seen":"s",)"
            R"("advice":"look"}],"error":"interrupted"})");
}

TEST(TenthsText, RoundsToATenthOfAMillisecond) {
  using std::chrono::microseconds;
  EXPECT_EQ(tenths_text(microseconds(0)), "0.0 ms");
  EXPECT_EQ(tenths_text(microseconds(4149)), "4.1 ms");
  EXPECT_EQ(tenths_text(microseconds(4150)), "4.2 ms");
  EXPECT_EQ(tenths_text(microseconds(1'000'000)), "1000.0 ms");
}

}  // namespace
}  // namespace mbgate::ctl

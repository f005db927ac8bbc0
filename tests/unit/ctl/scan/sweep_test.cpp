// SPDX-License-Identifier: Apache-2.0
#include "ctl/scan/sweep.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

namespace mbgate::ctl {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

SweepPlan plan_of(std::vector<std::uint8_t> units, std::string_view bauds,
                  std::string_view parities) {
  return {{"/dev/x", *parse_modes(bauds, parities, "1"), 100ms}, std::move(units)};
}

Heard heard_of(HeardKind kind, std::size_t bytes = 0, std::uint8_t unit = 0) {
  return {kind, bytes, unit};
}

/// A line where units answer in one mode each; it keeps what it was asked.
class ScriptedLine {
 public:
  void at(const std::string& mode, std::uint8_t unit, Heard heard) {
    script_[{mode, unit}] = std::move(heard);
  }
  void refuse(const std::string& mode) { refused_ = mode; }
  void break_before(std::uint8_t unit) { broken_ = unit; }

  std::optional<std::string> run(Sweep& sweep) {
    return sweep.run({[this](const LineMode& mode) -> std::optional<std::string> {
                        mode_ = mode_text(mode);
                        return mode_ == refused_ ? std::optional<std::string>("too fast")
                                                 : std::nullopt;
                      },
                      [this](std::uint8_t unit) -> Result<Heard, std::string> {
                        if (unit == broken_) {
                          return {boost::system::in_place_error, "the port has disappeared"};
                        }
                        asked.push_back(mode_ + " " + std::to_string(unit));
                        return script_[{mode_, unit}];
                      },
                      [this](const std::string& text) { shown.push_back(text); }});
  }

  std::vector<std::string> asked;
  std::vector<std::string> shown;

 private:
  std::map<std::pair<std::string, std::uint8_t>, Heard> script_;
  std::string mode_;
  std::string refused_;
  std::optional<std::uint8_t> broken_;
};

TEST(Sweep, AsksEveryUnitInEveryModeWhereNobodyAnswers) {
  ScriptedLine line;
  Sweep sweep(plan_of({1, 2}, "9600,19200", "even,none"));
  EXPECT_EQ(line.run(sweep), std::nullopt);
  EXPECT_THAT(line.asked, ElementsAre("9600 8E1 1", "9600 8E1 2", "9600 8N1 1", "9600 8N1 2",
                                      "19200 8E1 1", "19200 8E1 2", "19200 8N1 1", "19200 8N1 2"));
  EXPECT_EQ(sweep.best(), nullptr);
  EXPECT_EQ(nobody_text(sweep), "no unit answered at /dev/x in 4 modes");
  EXPECT_THAT(sweep_notes(sweep), IsEmpty());
}

TEST(Sweep, EndsAfterTheFirstModeWithAnAnswerAndAsksAllUnitsThere) {
  ScriptedLine line;
  line.at("9600 8N1", 1, heard_of(HeardKind::answer));
  line.at("9600 8N1", 3, heard_of(HeardKind::answer));
  Sweep sweep(plan_of({1, 2, 3}, "9600,19200", "even,none"));
  line.run(sweep);
  EXPECT_THAT(line.asked, ElementsAre("9600 8E1 1", "9600 8E1 2", "9600 8E1 3", "9600 8N1 1",
                                      "9600 8N1 2", "9600 8N1 3"));
  ASSERT_NE(sweep.best(), nullptr);
  EXPECT_EQ(mode_text(sweep.best()->mode), "9600 8N1");
  EXPECT_THAT(sweep.best()->units, ElementsAre(1, 3));
  EXPECT_THAT(line.shown, ElementsAre("9600 8E1 (1 of 4): asking unit 1, 0 found",
                                      "9600 8E1 (1 of 4): asking unit 2, 0 found",
                                      "9600 8E1 (1 of 4): asking unit 3, 0 found",
                                      "9600 8N1 (2 of 4): asking unit 1, 0 found",
                                      "9600 8N1 (2 of 4): asking unit 2, 1 found",
                                      "9600 8N1 (2 of 4): asking unit 3, 1 found"));
}

TEST(Sweep, TriesAllModesIfToldAndTakesTheOneOfMostUnits) {
  ScriptedLine line;
  line.at("9600 8E1", 1, heard_of(HeardKind::answer));
  line.at("9600 8N1", 2, heard_of(HeardKind::answer));
  line.at("9600 8N1", 3, heard_of(HeardKind::answer));
  auto plan = plan_of({1, 2, 3}, "9600", "even,none,odd");
  plan.port.all_modes = true;
  Sweep sweep(plan);
  line.run(sweep);
  EXPECT_EQ(line.asked.size(), 9U);
  EXPECT_EQ(mode_text(sweep.best()->mode), "9600 8N1");
  EXPECT_THAT(sweep_notes(sweep),
              ElementsAre("at 9600 8E1 unit 1 answered too, and was not identified: scan again "
                          "with only this rate and parity"));
}

TEST(Sweep, CountsALateAnswerAndNoOtherFrame) {
  ScriptedLine line;
  line.at("9600 8E1", 2, heard_of(HeardKind::other_frame, 7, 1));
  line.at("9600 8E1", 3, heard_of(HeardKind::other_frame, 7, 77));
  Sweep sweep(plan_of({1, 2, 3}, "9600,19200", "even"));
  line.run(sweep);
  EXPECT_EQ(line.asked.size(), 3U);
  EXPECT_THAT(sweep.best()->units, ElementsAre(1));
  EXPECT_THAT(sweep_notes(sweep),
              ElementsAre("at 9600 8E1 frames of units 1, 77 came late or without a request: a "
                          "longer --wait may help, or another client is on the line"));
}

TEST(Sweep, NamesWhatItDidNotUnderstand) {
  ScriptedLine line;
  line.at("9600 8E1", 1, heard_of(HeardKind::bad_crc, 7));
  line.at("9600 8E1", 2, heard_of(HeardKind::noise, 3));
  line.at("9600 8E1", 3, heard_of(HeardKind::noise, 2));
  line.at("9600 8N1", 3, heard_of(HeardKind::noise, 1));
  line.at("9600 8O1", 1, heard_of(HeardKind::bad_crc, 5));
  Sweep sweep(plan_of({1, 2, 3}, "9600", "even,none,odd"));
  line.run(sweep);
  EXPECT_EQ(sweep.best(), nullptr);
  EXPECT_THAT(
      sweep_notes(sweep),
      ElementsAre("at 9600 8E1 12 bytes heard that are not an answer: 1 frame with a bad CRC, "
                  "and no frame after 2 requests",
                  "at 9600 8N1 1 byte heard that is not an answer: no frame after 1 request",
                  "at 9600 8O1 5 bytes heard that are not an answer: 1 frame with a bad CRC, "
                  "as if two units had one address"));
}

TEST(Sweep, LeavesOutAModeThatThePortCannotHave) {
  ScriptedLine line;
  line.refuse("115200 8E1");
  Sweep sweep(plan_of({1}, "115200,9600", "even"));
  line.run(sweep);
  EXPECT_THAT(line.asked, ElementsAre("9600 8E1 1"));
  EXPECT_THAT(sweep_notes(sweep), ElementsAre("115200 8E1 was left out: too fast"));
  EXPECT_EQ(nobody_text(sweep), "no unit answered at /dev/x in 1 mode");
}

TEST(Sweep, EndsWithTheLineAndKeepsWhatItHas) {
  ScriptedLine line;
  line.at("9600 8E1", 1, heard_of(HeardKind::answer));
  line.break_before(2);
  Sweep sweep(plan_of({1, 2}, "9600", "even"));
  EXPECT_EQ(line.run(sweep), "the port has disappeared");
  EXPECT_THAT(sweep.best()->units, ElementsAre(1));
}

TEST(Sweep, SaysHowLongItTakesAtMost) {
  // 15 characters of 11 bits and 3.5 more are 21.2 ms; then the wait, and 20 ms for the mode.
  const auto one = plan_of({1}, "9600", "even");
  EXPECT_EQ(std::chrono::round<std::chrono::microseconds>(longest(one)), 141'198us);
  EXPECT_EQ(sweep_announcement(one),
            "asking 1 unit at /dev/x at 9600 8E1: 1s at most, and some seconds for each that "
            "answers; only reads are sent");
  std::vector<std::uint8_t> units(32);
  EXPECT_EQ(sweep_announcement(plan_of(units, "9600,19200,115200,38400,57600", "even,none,odd")),
            "asking 32 units at /dev/x in 15 modes, 9600 8E1 first: 53s at most, and some seconds "
            "for each that answers; only reads are "
            "sent");
}

TEST(Units, AreWrittenAsRanges) {
  EXPECT_EQ(units_text({3}), "unit 3");
  EXPECT_EQ(units_text({1, 2, 3, 7, 9, 10}), "units 1-3, 7, 9-10");
}

}  // namespace
}  // namespace mbgate::ctl

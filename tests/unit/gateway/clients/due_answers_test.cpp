// SPDX-License-Identifier: Apache-2.0
// The answers of a connection alone: which of them go out now, and how many are still due.
#include <gmock/gmock.h>

#include "gateway/clients/client_session.hpp"

namespace mbgate::gateway {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

using namespace std::chrono_literals;

constexpr bus::Instant kNow{10s};

DueAnswers::Answer answer_number(std::uint8_t number) { return {.adu = {number}}; }

modbus::MbapBytes number(std::uint8_t number) { return {number}; }

TEST(DueAnswers, GoOutAsSoonAsTheyAreThereWhereNobodyAsksForTheirOrder) {
  DueAnswers answers(false);
  const AnswerId first = answers.open();
  const AnswerId second = answers.open();
  EXPECT_THAT(answers.close(second, answer_number(2), kNow), ElementsAre(number(2)));
  EXPECT_THAT(answers.close(first, answer_number(1), kNow), ElementsAre(number(1)));
}

TEST(DueAnswers, WaitForThoseBeforeThemWhereTheListenerAsksForTheirOrder) {
  DueAnswers answers(true);
  const AnswerId first = answers.open();
  const AnswerId second = answers.open();
  const AnswerId third = answers.open();
  EXPECT_THAT(answers.close(third, answer_number(3), kNow), IsEmpty());
  EXPECT_THAT(answers.close(second, std::nullopt, kNow), IsEmpty());  // there is none
  EXPECT_THAT(answers.close(first, answer_number(1), kNow), ElementsAre(number(1), number(3)));
  EXPECT_THAT(answers.close(answers.open(), answer_number(4), kNow), ElementsAre(number(4)));
}

TEST(DueAnswers, AreOutstandingUntilTheyWereWritten) {
  for (const bool ordered : {false, true}) {
    DueAnswers answers(ordered);
    const AnswerId first = answers.open();
    const AnswerId second = answers.open();
    EXPECT_EQ(answers.outstanding(), 2U) << ordered;
    answers.close(first, answer_number(1), kNow);
    EXPECT_EQ(answers.outstanding(), 2U) << ordered;
    answers.confirm_sent();
    EXPECT_EQ(answers.outstanding(), 1U) << ordered;
    answers.close(second, std::nullopt, kNow);
    EXPECT_EQ(answers.outstanding(), 0U) << ordered;
    answers.confirm_sent();  // of one that is not known
    EXPECT_EQ(answers.outstanding(), 0U) << ordered;
  }
}

TEST(DueAnswers, AreNotSentWhenTheClientHasGivenUp) {
  for (const bool ordered : {false, true}) {
    DueAnswers answers(ordered);
    const AnswerId first = answers.open();
    EXPECT_THAT(answers.close(first, DueAnswers::Answer{number(1), kNow}, kNow + 1ms), IsEmpty());
    EXPECT_EQ(answers.outstanding(), 0U);
  }
}

TEST(DueAnswers, AreNotSentWhenTheClientGaveUpWhileTheyWaitedForThoseBefore) {
  DueAnswers answers(true);
  const AnswerId first = answers.open();
  answers.close(answers.open(), DueAnswers::Answer{number(2), kNow + 1ms}, kNow);
  EXPECT_THAT(answers.close(first, answer_number(1), kNow + 2ms), ElementsAre(number(1)));
}

TEST(DueAnswers, AreDroppedWhileTheyWaitButThoseToStops) {
  DueAnswers answers(true);
  const AnswerId first = answers.open();
  answers.close(answers.open(), answer_number(2), kNow);
  answers.close(answers.open(), DueAnswers::Answer{number(3), bus::Instant::max(), true}, kNow);
  answers.drop_waiting();
  EXPECT_THAT(answers.close(first, answer_number(1), kNow), ElementsAre(number(1), number(3)));
}

}  // namespace
}  // namespace mbgate::gateway

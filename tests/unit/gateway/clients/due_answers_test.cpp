// SPDX-License-Identifier: Apache-2.0
// The answers of a connection alone: which of them go out now, and how many are still due.
#include <gmock/gmock.h>

#include "gateway/clients/client_session.hpp"

namespace mbgate::gateway {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

modbus::MbapBytes answer_number(std::uint8_t number) { return {number}; }

TEST(DueAnswers, GoOutAsSoonAsTheyAreThereWhereNobodyAsksForTheirOrder) {
  DueAnswers answers(false);
  const AnswerId first = answers.open();
  const AnswerId second = answers.open();
  EXPECT_THAT(answers.close(second, answer_number(2)), ElementsAre(answer_number(2)));
  EXPECT_THAT(answers.close(first, answer_number(1)), ElementsAre(answer_number(1)));
}

TEST(DueAnswers, WaitForThoseBeforeThemWhereTheListenerAsksForTheirOrder) {
  DueAnswers answers(true);
  const AnswerId first = answers.open();
  const AnswerId second = answers.open();
  const AnswerId third = answers.open();
  EXPECT_THAT(answers.close(third, answer_number(3)), IsEmpty());
  EXPECT_THAT(answers.close(second, std::nullopt), IsEmpty());  // there is none
  EXPECT_THAT(answers.close(first, answer_number(1)),
              ElementsAre(answer_number(1), answer_number(3)));
  EXPECT_THAT(answers.close(answers.open(), answer_number(4)), ElementsAre(answer_number(4)));
}

TEST(DueAnswers, AreOutstandingUntilTheyWereWritten) {
  for (const bool ordered : {false, true}) {
    DueAnswers answers(ordered);
    const AnswerId first = answers.open();
    const AnswerId second = answers.open();
    EXPECT_EQ(answers.outstanding(), 2U) << ordered;
    answers.close(first, answer_number(1));
    EXPECT_EQ(answers.outstanding(), 2U) << ordered;
    answers.confirm_sent();
    EXPECT_EQ(answers.outstanding(), 1U) << ordered;
    answers.close(second, std::nullopt);
    EXPECT_EQ(answers.outstanding(), 0U) << ordered;
    answers.confirm_sent();  // of one that is not known
    EXPECT_EQ(answers.outstanding(), 0U) << ordered;
  }
}

}  // namespace
}  // namespace mbgate::gateway

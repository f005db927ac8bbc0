// SPDX-License-Identifier: Apache-2.0
#include "ctl/doctor/trial.hpp"

#include <gtest/gtest.h>

#include "line_bytes.hpp"

namespace mbgate::ctl {
namespace {

using std::chrono::milliseconds;

const SentRead& question() {
  static const SentRead kQuestion(5, {modbus::Table::holding_registers, 0, 1});
  return kQuestion;
}

TEST(Trial, IsTimedToTheFirstBytesOfTheAnswer) {
  const auto answer = rtu_frame(5, kAnswerPdu);
  const LineBytes begin(answer.begin(), answer.begin() + 3);
  const LineBytes end(answer.begin() + 3, answer.end());
  const auto trial = understand(question(), {{milliseconds(4), begin}, {milliseconds(20), end}});
  EXPECT_EQ(trial.kind, HeardKind::answer);
  EXPECT_EQ(trial.answers, 1U);
  EXPECT_EQ(trial.took, milliseconds(4));
  EXPECT_FALSE(trial.echo);
  EXPECT_FALSE(trial.other_client);
}

TEST(Trial, TellsTheEchoFromTheAnswer) {
  const auto request = rtu_frame(5, kReadPdu);
  const auto trial = understand(
      question(), {{milliseconds(-1), request}, {milliseconds(7), rtu_frame(5, {0x83, 0x02})}});
  EXPECT_TRUE(trial.echo);
  EXPECT_EQ(trial.kind, HeardKind::answer);
  EXPECT_EQ(trial.exception, 0x02);
  EXPECT_EQ(trial.took, milliseconds(7));
  EXPECT_FALSE(trial.other_client);
  const auto alone = understand(question(), {{milliseconds(1), request}});
  EXPECT_TRUE(alone.echo);
  EXPECT_EQ(alone.kind, HeardKind::silence);
}

TEST(Trial, CountsTheAnswers) {
  const auto trial = understand(question(), {{milliseconds(4), rtu_frame(5, kAnswerPdu)},
                                             {milliseconds(9), rtu_frame(5, {0x03, 0x02, 0, 7})}});
  EXPECT_EQ(trial.answers, 2U);
  EXPECT_EQ(trial.took, milliseconds(4));
}

TEST(Trial, KnowsAnotherClientByItsRequests) {
  const auto trial =
      understand(question(), {{milliseconds(4), rtu_frame(5, kAnswerPdu)},
                              {milliseconds(9), rtu_frame(5, {0x03, 0x00, 0x07, 0x00, 0x02})}});
  EXPECT_EQ(trial.answers, 1U);
  EXPECT_TRUE(trial.other_client);
}

TEST(Trial, IsNotAnsweredBySilenceOrDamage) {
  EXPECT_EQ(understand(question(), {}).kind, HeardKind::silence);
  auto damaged = rtu_frame(5, kAnswerPdu);
  damaged.back() ^= 1U;
  const auto trial = understand(question(), {{milliseconds(4), damaged}});
  EXPECT_EQ(trial.kind, HeardKind::bad_crc);
  EXPECT_EQ(trial.answers, 0U);
  EXPECT_EQ(trial.bytes, 7U);
}

TEST(Trial, TakesNoTimeBelowZero) {
  const auto trial = understand(question(), {{milliseconds(-4), rtu_frame(5, kAnswerPdu)}});
  EXPECT_EQ(trial.took, milliseconds(0));
}

}  // namespace
}  // namespace mbgate::ctl

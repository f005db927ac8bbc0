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
  EXPECT_EQ(trial.other_client, "");
}

TEST(Trial, TellsTheEchoFromTheAnswer) {
  const auto request = rtu_frame(5, kReadPdu);
  const auto trial = understand(
      question(), {{milliseconds(-1), request}, {milliseconds(7), rtu_frame(5, {0x83, 0x02})}});
  EXPECT_TRUE(trial.echo);
  EXPECT_EQ(trial.kind, HeardKind::answer);
  EXPECT_EQ(trial.exception, 0x02);
  EXPECT_EQ(trial.took, milliseconds(7));
  EXPECT_EQ(trial.other_client, "");
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
  EXPECT_EQ(trial.other_client, "unit 5: read holding registers 7..8");
}

TEST(Trial, TakesAWriteForOneOfAnotherClientThoughItMayBeItsAnswer) {
  const auto trial =
      understand(question(), {{milliseconds(4), rtu_frame(1, {0x06, 0x00, 0x01, 0x00, 0x02})}});
  EXPECT_EQ(trial.kind, HeardKind::other_frame);
  EXPECT_EQ(trial.other_client, "unit 1: write single register 1 = 0x0002");
}

TEST(Trial, KnowsItsEchoBehindAGlitchAndTakesItForNobodyElse) {
  const auto request = rtu_frame(5, kReadPdu);
  const auto trial = understand(question(), {{milliseconds(-2), {0xFF}},
                                             {milliseconds(-1), request},
                                             {milliseconds(7), rtu_frame(5, kAnswerPdu)}});
  EXPECT_TRUE(trial.echo);
  EXPECT_EQ(trial.other_client, "");
  EXPECT_EQ(trial.kind, HeardKind::answer);
  EXPECT_EQ(trial.answers, 1U);
  EXPECT_EQ(trial.took, milliseconds(7));
  const auto twice =
      understand(question(), {{milliseconds(1), request}, {milliseconds(9), request}});
  EXPECT_TRUE(twice.echo);
  EXPECT_EQ(twice.other_client, "");
}

TEST(Trial, HearsAnotherClientBeforeItsEchoToo) {
  const auto heard = one_after_the_other(
      {rtu_frame(7, kReadPdu), rtu_frame(5, kReadPdu), rtu_frame(5, kAnswerPdu)});
  const auto trial = understand(question(), {{milliseconds(4), heard}});
  EXPECT_TRUE(trial.echo);
  EXPECT_EQ(trial.kind, HeardKind::answer);
  EXPECT_EQ(trial.other_client, "unit 7: read holding registers 0");
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

Unasked unasked_in(const LineBytes& heard) {
  return understand_unasked({modbus::Table::holding_registers, 0, 1}, {3, 5}, heard);
}

TEST(Unasked, IsOfNoImportanceWhereItIsLittleOrOurs) {
  EXPECT_FALSE(unasked_in({}).is_foreign());
  EXPECT_FALSE(unasked_in({0x00, 0xFF}).is_foreign());
  EXPECT_FALSE(unasked_in(rtu_frame(3, kReadPdu)).is_foreign());
  const auto late =
      unasked_in(one_after_the_other({rtu_frame(5, kAnswerPdu), rtu_frame(3, kAnswerPdu), {0x00}}));
  EXPECT_FALSE(late.is_foreign());
  EXPECT_EQ(late.late_answers, 1U);
}

TEST(Unasked, IsOfAnotherClientWhereARequestIsHeard) {
  const auto other =
      unasked_in(one_after_the_other({rtu_frame(7, kReadPdu), rtu_frame(7, kAnswerPdu)}));
  EXPECT_TRUE(other.is_foreign());
  EXPECT_EQ(other.other_client, "unit 7: read holding registers 0");
}

TEST(Unasked, MayBeOfAnotherClientWhereThereIsMore) {
  const auto noise = unasked_in({0x00, 0x00, 0x00});
  EXPECT_TRUE(noise.is_foreign());
  EXPECT_EQ(noise.bytes, 3U);
  EXPECT_EQ(noise.other_client, "");
  // Of a unit that was not asked, and of one that was asked something else.
  EXPECT_EQ(unasked_in(rtu_frame(7, kAnswerPdu)).bytes, 7U);
  const auto answer = unasked_in(rtu_frame(5, {0x03, 0x04, 0, 1, 0, 2}));
  EXPECT_EQ(answer.bytes, 9U);
  EXPECT_EQ(answer.late_answers, 0U);
  EXPECT_TRUE(answer.is_foreign());
}

}  // namespace
}  // namespace mbgate::ctl

// SPDX-License-Identifier: Apache-2.0
#include "lone_echo.hpp"

namespace mbgate::test {
namespace {

TEST_F(Echo, IsTakenOutWhereItIsSaidToBe) {
  begin(true);
  send(kWritePdu);
  EXPECT_EQ(take("01 06 00"), "|");
  EXPECT_EQ(take("00 00 01 48 0A 01 86"), "|01 86");
  EXPECT_EQ(take(kSentWrite), std::string("|") + kSentWrite);  // the answer
  EXPECT_FALSE(echo_->is_spoilt());
  EXPECT_THAT(told(), IsEmpty());
}

TEST_F(Echo, IsFoundThoughItComesWhenTheRequestIsForgotten) {
  begin({});
  send(kReadPdu);
  transaction_.emplace(bus::Transaction{1, *modbus::Request::parse(pdu("07"))});
  EXPECT_EQ(take(kSentRead), "|");
  EXPECT_TRUE(echo_->is_unknown());
  answered("03 02 12 34");
  EXPECT_EQ(echo_->noticed(), bus::NoticedEcho::found);
}

TEST_F(Echo, ThatDiffersSpoilsWhatFollows) {
  begin(true);
  send(kReadPdu);
  EXPECT_EQ(take("01 03 00 00 01 01"), "|");
  EXPECT_TRUE(echo_->is_spoilt());
  EXPECT_THAT(told(), ElementsAre(LineFault::echo_differed));
  EXPECT_EQ(counters_.echo_mismatches, 1U);
  EXPECT_EQ(counters_.stray_bytes, 6U);
  send(kReadPdu);
  EXPECT_FALSE(echo_->is_spoilt());
  EXPECT_EQ(take(kSentRead), "|");
}

// The status 41 (hex) of unit 1 makes an answer that begins with 01 07 41 E2, as its request does.
TEST_F(Echo, IsNotProvenByAnAnswerThatBeginsLikeARequestWithoutFields) {
  begin(std::nullopt);
  send("07");
  EXPECT_EQ(take("01 07 41 E2 00"), "|00");
  EXPECT_TRUE(echo_->is_unknown());
  answered("07 41");
  EXPECT_TRUE(echo_->is_unknown());
  EXPECT_THAT(told(), IsEmpty());
}

TEST_F(Echo, ThatDifferedIsNotGivenOnLater) {
  begin(std::nullopt);
  echo_->find();
  send(kWritePdu);
  EXPECT_EQ(take("01 86 02 C3 A1"), "|");
  EXPECT_TRUE(echo_->is_unknown());
  EXPECT_EQ(release(), "");
}

TEST_F(Echo, IsNotLookedForWhereItIsSaidNotToBe) {
  begin(false);
  send(kReadPdu);
  EXPECT_EQ(take(kSentRead), std::string("|") + kSentRead);
  EXPECT_FALSE(echo_->is_learned());
  EXPECT_THAT(told(), IsEmpty());
}

TEST_F(Echo, IsFoundWhereNobodyHasSaid) {
  begin(std::nullopt);
  EXPECT_TRUE(echo_->is_unknown());
  send(kReadPdu);
  EXPECT_EQ(take("01 03 00 00"), "|");
  EXPECT_EQ(take("00 01 84 0A 55"), "|55");
  EXPECT_TRUE(echo_->is_unknown());
  answered("03 02 12 34");
  EXPECT_FALSE(echo_->is_unknown());
  EXPECT_TRUE(echo_->was_shown());
  EXPECT_THAT(told(), ElementsAre(LineFault::echo_found));
  send(kWritePdu);
  EXPECT_EQ(take(kSentWrite), "|");
}

TEST_F(Echo, IsHeldBackUntilWhatComesIsSomethingElse) {
  begin(std::nullopt);
  send(kReadPdu);
  EXPECT_EQ(take("01", Instant(5ms)), "|");
  EXPECT_EQ(take("03", Instant(7ms)), "|");
  EXPECT_EQ(take("02 12", Instant(9ms)), "01 03|02 12");
  ASSERT_EQ(held_.size(), 2U);
  EXPECT_EQ(held_[0].came, Instant(5ms));
  EXPECT_EQ(held_[1].came, Instant(7ms));
  EXPECT_EQ(held_[1].begin, 1U);
  EXPECT_EQ(take(kSentRead), std::string("|") + kSentRead);
  EXPECT_TRUE(echo_->is_unknown());
}

TEST_F(Echo, IsHeldBackNoLongerThanItIsWaitedFor) {
  begin(std::nullopt);
  send(kReadPdu);
  EXPECT_EQ(release(), "");
  EXPECT_EQ(take("01 03"), "|");
  EXPECT_EQ(release(), "01 03");
  EXPECT_EQ(release(), "");
  EXPECT_EQ(counters_.stray_bytes, 0U);
}

TEST_F(Echo, ThatMayBeTheAnswerIsGivenOnUntilThereIsOne) {
  begin(std::nullopt);
  send(kWritePdu);
  EXPECT_EQ(take(kSentWrite), std::string("|") + kSentWrite);
  EXPECT_TRUE(echo_->is_repetition(pdu(kWritePdu)));
  EXPECT_FALSE(echo_->is_repetition(pdu("06 0000 0002")));
  echo_->find();
  EXPECT_FALSE(echo_->is_unknown());
}

TEST_F(Echo, OnlyOfWhatIsAnsweredSoLooksLikeTheAnswer) {
  begin(true);
  send(kReadPdu);
  EXPECT_FALSE(echo_->is_repetition(pdu(kReadPdu)));
}

TEST_F(Echo, IsNotThereIfAReadIsAnsweredWithoutIt) {
  begin(std::nullopt);
  send(kWritePdu);
  answered(kWritePdu);
  EXPECT_TRUE(echo_->is_unknown());
  send("10 0000 0001 02 0001");
  answered("10 0000 0001");
  EXPECT_TRUE(echo_->is_unknown());
  send(kReadPdu);
  answered("03 02 12 34", false);
  EXPECT_TRUE(echo_->is_unknown());
  answered("03 02 12 34");
  EXPECT_FALSE(echo_->is_unknown());
  EXPECT_FALSE(echo_->was_shown());
}

TEST_F(Echo, ThatDidNotComeIsOwedOnce) {
  begin(true);
  send(kWritePdu);
  send(kWritePdu);
  EXPECT_EQ(take(kSentWrite), "|");
  EXPECT_FALSE(echo_->is_owed(pdu("06 0000 0002")));
  EXPECT_TRUE(echo_->is_owed(pdu(kWritePdu)));
  EXPECT_TRUE(echo_->take_owed(pdu(kWritePdu)));
  EXPECT_FALSE(echo_->take_owed(pdu(kWritePdu)));
  send(kWritePdu);
  EXPECT_EQ(take(kSentWrite), "|");
  EXPECT_FALSE(echo_->is_owed(pdu(kWritePdu)));
}

TEST_F(Echo, IsOwedForEachRequestThatWasSent) {
  begin(true);
  send(kWritePdu);
  send("06 0000 0002");
  send(kWritePdu);
  send(kWritePdu);
  EXPECT_EQ(take(kSentWrite), "|");
  EXPECT_TRUE(echo_->take_owed(pdu(kWritePdu)));
  EXPECT_TRUE(echo_->take_owed(pdu(kWritePdu)));
  EXPECT_FALSE(echo_->take_owed(pdu(kWritePdu)));
}

TEST_F(Echo, IsNotOwedIfThatOfALaterRequestHasCome) {
  begin(true);
  send(kWritePdu);
  send(kReadPdu);
  EXPECT_EQ(take(kSentRead), "|");
  send(kWritePdu);
  EXPECT_EQ(take(kSentWrite), "|");
  EXPECT_FALSE(echo_->is_owed(pdu(kWritePdu)));
}

TEST_F(Echo, IsNotOwedForEver) {
  for (const auto& [later, owed] : {std::pair{11s, true}, std::pair{12s, false}}) {
    begin(true);
    send(kWritePdu, Instant(0s));
    send(kWritePdu, Instant(0s));
    send(kWritePdu, Instant(later));
    EXPECT_EQ(take(kSentWrite), "|");
    EXPECT_EQ(echo_->is_owed(pdu(kWritePdu)), owed);
  }
}

TEST_F(Echo, IsNotOwedWhenTheLineWasOpenedAnew) {
  begin(true);
  send(kWritePdu);
  send(kWritePdu);
  echo_->open();
  send(kWritePdu);
  EXPECT_EQ(take(kSentWrite), "|");
  EXPECT_FALSE(echo_->is_owed(pdu(kWritePdu)));
}

TEST_F(Echo, OfWhatWasSentBeforeTheLineWasOpenedAnewIsNotExpected) {
  for (const auto setting : {std::optional(true), std::optional<bool>()}) {
    begin(setting);
    send(kReadPdu);
    EXPECT_EQ(take("01 03"), "|");
    echo_->open();
    EXPECT_EQ(take("02 03 00"), "|02 03 00");
    EXPECT_EQ(release(), "");
    EXPECT_EQ(counters_.echo_mismatches, 0U);
  }
}

TEST_F(Echo, ThatWasFoundIsThereWhenTheLineIsOpenedAgain) {
  begin(std::nullopt);
  echo_->find();
  echo_->open();
  EXPECT_EQ(echo_->noticed(), bus::NoticedEcho::found);
  send(kWritePdu);
  EXPECT_EQ(take(kSentWrite), "|");
}

TEST_F(Echo, ThatWasNotThereIsUnknownWhenTheLineIsOpenedAgain) {
  begin(std::nullopt);
  send(kReadPdu);
  answered("03 02 12 34");
  EXPECT_FALSE(echo_->is_unknown());
  echo_->note_unproven();
  echo_->note_unproven();
  echo_->open();
  EXPECT_TRUE(echo_->is_unknown());
  echo_->note_unproven();
  EXPECT_THAT(told(), ElementsAre(LineFault::echo_unproven, LineFault::echo_unproven));
}

}  // namespace
}  // namespace mbgate::test

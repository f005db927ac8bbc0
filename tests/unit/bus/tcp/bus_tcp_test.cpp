// SPDX-License-Identifier: Apache-2.0
// A bus that is a connection: identifiers, timeouts, framing.
#include "bus_tcp_rig.hpp"

namespace mbgate::test {
namespace {

using testing::UnorderedElementsAre;

TEST_F(BusTcp, AsksAtOnceAndTakesTheAnswerInPieces) {
  open(tcp());
  bus::Job& read = job(kRead, 255);
  submit(read);
  EXPECT_THAT(frames_, ElementsAre("00 01 00 00 00 06 FF 03 00 00 00 01"));
  for (const std::string_view byte : {"00", "01", "00", "00", "00", "05", "FF", "03", "02", "12"}) {
    line(byte);
    EXPECT_THAT(endings_, IsEmpty());
  }
  line("34");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(hex(read.transactions[0].response->bytes()), "03 02 12 34");
}

TEST_F(BusTcp, TakesUnitZeroForADevice) {
  open(tcp());
  bus::Job& read = job(kRead, 0);
  read.transactions[0].broadcast = std::nullopt;
  submit(read);
  answer(0, "00 03 02 12 34");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusTcp, AsksOneAfterTheOtherByDefault) {
  open(tcp());
  submit(job(kRead, 1));
  submit(job(kRead, 2));
  EXPECT_THAT(units(), ElementsAre(1));
  answer(0, "01 03 02 12 34");
  EXPECT_THAT(units(), ElementsAre(1, 2));
  EXPECT_EQ(frames_[1].substr(0, 5), "00 02");
}

TEST_F(BusTcp, HasAsManyOnTheirWayAsItMay) {
  open(tcp(3));
  for (const std::uint8_t address : std::initializer_list<std::uint8_t>{1, 1, 2, 3, 4}) {
    submit(job(kRead, address));
  }
  EXPECT_THAT(units(), ElementsAre(1, 1, 2));
  answer(1, "01 03 02 12 34");
  EXPECT_THAT(units(), ElementsAre(1, 1, 2, 3));
}

TEST_F(BusTcp, AReloadMayLetMoreBeOnTheirWay) {
  open(tcp());
  submit(job(kRead, 1));
  submit(job(kRead, 2));
  EXPECT_THAT(frames_, SizeIs(1));
  update(tcp(2), {});
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(BusTcp, AnswersMayComeInAnyOrder) {
  open(tcp(3));
  bus::Job& first = job("03 0000 0001");
  bus::Job& second = job("03 0001 0001");
  bus::Job& third = job("03 0002 0001");
  for (bus::Job* read : {&first, &second, &third}) {
    submit(*read);
  }
  line(
      "00 03 00 00 00 05 01 03 02 33 33 00 01 00 00 00 05 01 03 02 11 11"
      "00 02 00 00 00 05 01 03 02 22 22");
  EXPECT_THAT(endings_, SizeIs(3));
  EXPECT_EQ(hex(first.transactions[0].response->bytes()), "03 02 11 11");
  EXPECT_EQ(hex(second.transactions[0].response->bytes()), "03 02 22 22");
  EXPECT_EQ(hex(third.transactions[0].response->bytes()), "03 02 33 33");
}

TEST_F(BusTcp, TheTimeoutRunsFromTheTransmission) {
  drive::Device holding{"holding", {}, 2, settings().timing};
  holding.timing.response_wait = 30ms;
  open(tcp(2), {holding});
  submit(job(kRead, 1));
  submit(job(kRead, 2));
  const Instant start = now_;
  advance(1s);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::no_answer));
  EXPECT_EQ(ended_at_[0] - start, 100ms);
  EXPECT_EQ(ended_at_[1] - start, 130ms);
  EXPECT_EQ(bus_->counters().timeouts, 2U);
  EXPECT_EQ(bus_->devices()[1].health.unanswered_in_row(), 1U);
}

TEST_F(BusTcp, ALateAnswerIsNobodys) {
  auto retrying = tcp();
  retrying.timing.retries = 1;
  open(retrying);
  bus::Job& read = job(kRead);
  submit(read);
  advance(100ms);
  EXPECT_THAT(frames_, SizeIs(2));
  EXPECT_EQ(bus_->counters().retries, 1U);
  answer(0, "01 03 02 11 11");
  EXPECT_THAT(endings_, IsEmpty());
  EXPECT_EQ(bus_->counters().unsolicited_frames, 1U);
  answer(1, "01 03 02 22 22");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(hex(read.transactions[0].response->bytes()), "03 02 22 22");
}

TEST_F(BusTcp, WritesAreNotRepeated) {
  auto retrying = tcp();
  retrying.timing.retries = 3;
  open(retrying);
  submit(job("06 0000 0001"));
  advance(1s);
  EXPECT_THAT(frames_, SizeIs(1));
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
}

TEST_F(BusTcp, AnswersOfAnotherFunctionOrIdentifierAreCountedAndTheTimeoutGoesOn) {
  open(tcp());
  submit(job("06 0000 0001"));
  const Instant start = now_;
  advance(50ms);
  answer(0, "01 05 00 00 00 01");               // function
  line("12 34 00 00 00 06 01 06 00 00 00 01");  // identifier
  EXPECT_EQ(bus_->counters().unsolicited_frames, 2U);
  advance(1s);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_EQ(ended_at_[0] - start, 100ms);
}

TEST_F(BusTcp, TheUnitOfAnAnswerDoesNotMatter) {
  open(tcp());
  submit(job(kRead, 7));
  answer(0, "FF 03 02 12 34");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusTcp, TheUnitOfAnAnswerMattersIfAskedFor) {
  auto checking = tcp();
  checking.check_unit = true;
  open(checking);
  submit(job(kRead, 7));
  answer(0, "FF 03 02 12 34");
  EXPECT_THAT(endings_, IsEmpty());
  EXPECT_EQ(bus_->counters().unsolicited_frames, 1U);
  answer(0, "07 03 02 12 34");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusTcp, AReloadMayAskForTheUnit) {
  auto checking = tcp();
  open(checking);
  checking.check_unit = true;
  update(checking, {});
  submit(job(kRead, 7));
  answer(0, "FF 03 02 12 34");
  EXPECT_THAT(endings_, IsEmpty());
}

TEST_F(BusTcp, ALengthThatCannotBeEndsTheConnection) {
  open(tcp(2));
  submit(job(kRead, 1));
  submit(job(kRead, 2));
  submit(job(kRead, 3));
  line(
      "00 01 00 00 00 05 01 03 02 12 34"  // what came before is good
      "00 02 00 00 00 01 02 03");
  EXPECT_EQ(closes_, 1U);
  EXPECT_FALSE(bus_->link().serves());
  EXPECT_THAT(endings_, UnorderedElementsAre(Ending::answered, Ending::closed, Ending::closed));
  EXPECT_EQ(bus_->counters().losses, 1U);
  EXPECT_EQ(*next_deadline() - now_, 100ms);
}

TEST_F(BusTcp, AProtocolThatCannotBeEndsTheConnection) {
  open(tcp());
  bus::Job& read = job(kRead);
  submit(read);
  line("00 01 00");
  EXPECT_EQ(closes_, 0U);
  line("01");
  EXPECT_EQ(closes_, 1U);
  EXPECT_THAT(endings_, ElementsAre(Ending::closed));
  EXPECT_TRUE(read.was_on_wire);
}

TEST_F(BusTcp, ANewConnectionKnowsNothingOfTheOldOne) {
  open(tcp());
  submit(job(kRead));
  line("00 01 00 00 00 05 01");
  bus_->handle_lost(now_);
  drain();
  EXPECT_THAT(endings_, ElementsAre(Ending::closed));
  bus_->handle_opened(now_);
  submit(job(kRead));
  answer(0, "01 03 02 11 11");
  EXPECT_THAT(endings_, SizeIs(1));
  answer(1, "01 03 02 22 22");
  EXPECT_THAT(endings_, ElementsAre(Ending::closed, Ending::answered));
}

TEST_F(BusTcp, NoIdentifierIsUsedTwiceAtATime) {
  auto patient = tcp(2);
  patient.timing.response_timeout = 1h;
  open(patient);
  bus::Job& slow = job(kRead, 1);
  slow.deadline = now_ + 10h;
  submit(slow);
  for (int times = 0; times < 0xFFFE; ++times) {
    jobs_.resize(1);
    frames_.resize(1);
    submit(job(kRead, 2));
    answer(1, "02 03 02 12 34");
  }
  jobs_.resize(1);
  submit(job(kRead, 2));
  EXPECT_EQ(frames_[0].substr(0, 5), "00 01");
  EXPECT_EQ(frames_[1].substr(0, 5), "FF FF");
  EXPECT_EQ(frames_[2].substr(0, 5), "00 00");
  answer(2, "02 03 02 12 34");
  submit(job(kRead, 2));
  EXPECT_EQ(frames_[3].substr(0, 5), "00 02");
}

TEST_F(BusTcp, StoppingEndsWhatIsOnItsWayUnanswered) {
  open(tcp(2));
  submit(job(kRead, 1));
  submit(job(kRead, 2));
  submit(job(kRead, 3));
  bus_->stop(now_);
  drain();
  EXPECT_THAT(endings_, ElementsAre(Ending::cancelled));
  answer(0, "01 03 02 12 34");
  bus_->give_up(now_);
  drain();
  EXPECT_THAT(endings_, ElementsAre(Ending::cancelled, Ending::answered, Ending::no_answer));
}

TEST_F(BusTcp, ShowsWhetherAnAnswerIsWaitedFor) {
  open(tcp());
  EXPECT_EQ(bus_->parts().line.state(now_), bus::LineState::idle);
  submit(job(kRead));
  EXPECT_EQ(bus_->parts().line.state(now_), bus::LineState::waiting_for_reply);
}

TEST_F(BusTcp, ABroadcastIsAnErrorOfOurs) {
  open(tcp());
  EXPECT_DEATH(submit(job("06 0000 0001", 0)), "");
}

TEST_F(BusTcp, NothingIsSentOnANewConnectionBeforeTheServerIsReady) {
  auto slow_start = tcp();
  slow_start.connect_delay = 50ms;
  bus_.emplace(slow_start, usual_devices(slow_start));
  bus_->start();
  submit(job(kRead));
  bus_->handle_opened(now_);
  drain();
  advance(49ms);
  EXPECT_THAT(frames_, IsEmpty());
  advance(1ms);
  EXPECT_THAT(frames_, SizeIs(1));
}

}  // namespace
}  // namespace mbgate::test

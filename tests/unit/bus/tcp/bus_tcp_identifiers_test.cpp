// SPDX-License-Identifier: Apache-2.0
// A server that does not return transaction identifiers: late answers are told apart as on a serial
// line.
#include "bus_tcp_rig.hpp"
#include "unit/bus/queue/stop_axis.hpp"

namespace mbgate::test {
namespace {

class BusTcpWithoutIdentifiers : public BusTcp {
 protected:
  static bus::BusSettings unchecked() {
    auto unchecked = tcp();
    unchecked.check_transaction = false;
    unchecked.check_unit = true;
    unchecked.listen_first = 0ms;
    return unchecked;
  }
  /// An answer with the identifier 0.
  void answer(std::string_view unit_and_pdu) {
    const auto body = unhex(unit_and_pdu);
    line("00 00 00 00 00" + hex(std::vector{static_cast<std::uint8_t>(body.size())}) + hex(body));
  }
};

TEST_F(BusTcpWithoutIdentifiers, AnyIdentifierWillDo) {
  open(unchecked());
  submit(job(kRead));
  answer("02 03 02 12 34");
  EXPECT_THAT(endings_, IsEmpty());  // another unit
  answer("01 03 02 12 34");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

// The configuration takes them for one device.
TEST_F(BusTcpWithoutIdentifiers, TheAnswerOfAnotherUnitIsNotOneThatIsOwed) {
  drive::Device server{"server", {}, 255, unchecked().timing};
  open(unchecked(), {server});
  for (const std::uint8_t unit : std::array<std::uint8_t, 2>{1, 2}) {
    auto& read = job(kRead, 255);
    read.transactions[0].unit = unit;
    submit(read);
    advance(unit == 1 ? 400ms : 10ms);
  }
  ASSERT_THAT(units(), ElementsAre(1, 2));
  answer("02 03 02 22 22");
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::answered));
}

// Its answer could not be told from that of the stop.
TEST_F(BusTcpWithoutIdentifiers, AStopWaitsForARunningTransactionNoLongerThanStopWait) {
  auto slow = unchecked();
  slow.timing.response_timeout = 1s;
  open(slow, {axis(slow)});
  submit(job(kRead, 2));
  submit(job_of(1, kStop));
  advance(99ms);
  EXPECT_THAT(units(), ElementsAre(2));
  advance(1ms);
  EXPECT_THAT(units(), ElementsAre(2, 1));
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
}

TEST_F(BusTcpWithoutIdentifiers, ADeviceIsLeftAloneUntilItsLateAnswerCannotBeMistaken) {
  open(unchecked());
  submit(job(kRead));
  advance(100ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  submit(job(kOther));
  submit(job(kRead, 2));
  EXPECT_THAT(units(), ElementsAre(1, 2));
  answer("01 03 02 11 11");  // to the first
  EXPECT_EQ(bus_->counters().late_responses, 1U);
  answer("02 03 02 22 22");
  EXPECT_THAT(units(), ElementsAre(1, 2, 1));
  answer("01 03 02 33 33");
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::answered, Ending::answered));
  EXPECT_EQ(hex(jobs_[1].transactions[0].response->bytes()), "03 02 33 33");
}

// Two drives at one address behind the server.
TEST_F(BusTcpWithoutIdentifiers, SecondAnswersAreLearnedWhetherSomethingIsAskedOrNot) {
  open(unchecked());
  advance(11s);
  submit(job(kRead));
  answer("01 03 02 12 34");
  answer("01 03 02 12 34");
  EXPECT_THAT(notices_, ElementsAre(bus::DeviceNotice::Kind::second_answer));
  advance(100ms);
  submit(job(kRead));
  answer("01 03 02 12 34");
  submit(job("06 0001 0001"));
  EXPECT_THAT(frames_, SizeIs(2));  // held
  advance(99ms);
  EXPECT_THAT(frames_, SizeIs(2));
  advance(1ms);
  EXPECT_THAT(frames_, SizeIs(3));
}

TEST_F(BusTcpWithoutIdentifiers, TheSecondAnswerToAnotherRequestIsOneToo) {
  open(unchecked());
  advance(11s);
  submit(job(kRead));
  answer("01 03 02 12 34");
  submit(job("06 0001 0001"));
  answer("01 03 02 12 34");
  EXPECT_THAT(notices_, ElementsAre(bus::DeviceNotice::Kind::second_answer));
  answer("01 06 0001 0001");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
}

TEST_F(BusTcpWithoutIdentifiers, TheQuarantineEndsAsOnASerialLine) {
  open(unchecked());
  submit(job(kRead));
  advance(100ms);
  submit(job(kOther));
  EXPECT_THAT(frames_, SizeIs(1));
  advance(119ms);
  EXPECT_THAT(frames_, SizeIs(1));
  advance(1ms);
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(BusTcpWithoutIdentifiers, AnAnswerBelongsToTheOldestRequestThatItFits) {
  open(unchecked(), {axis(unchecked())});
  submit(job("10 007C 0001 02 0066"));
  advance(100ms);
  submit(job(kStopBy16));
  EXPECT_THAT(frames_, SizeIs(2));
  answer("01 10 007C 0001");
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));  // that was the move's
  answer("01 10 007C 0001");
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::answered));
}

TEST_F(BusTcpWithoutIdentifiers, AStopWaitsForTheAnswerThatIsDue) {
  open(unchecked(), {axis(unchecked())});
  submit(job(kRead, 2));
  submit(job(kStop));
  EXPECT_THAT(units(), ElementsAre(2));
  answer("02 03 02 12 34");
  EXPECT_THAT(units(), ElementsAre(2, 1));
}

TEST_F(BusTcpWithoutIdentifiers, ANewConnectionIsListenedToWhileSomethingIsOwed) {
  open(unchecked());
  submit(job(kRead));
  bus_->handle_lost(now_, bus::Loss::failed);
  drain();
  advance(50ms);
  reopen();
  submit(job(kRead, 2));
  EXPECT_THAT(frames_, SizeIs(1));
  advance(169ms);
  EXPECT_THAT(frames_, SizeIs(1));
  advance(1ms);  // the response timeout, the quarantine and what an adapter keeps
  EXPECT_THAT(frames_, SizeIs(2));
}

}  // namespace
}  // namespace mbgate::test

// SPDX-License-Identifier: Apache-2.0
// Answers that come after their time, and how long their device is left alone.
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

using Kind = bus::DeviceNotice::Kind;

class BusLate : public Bus {
 protected:
  /// Writes are sent once more.
  static bus::BusSettings repeating() {
    auto repeating = settings();
    repeating.timing.retry_writes = true;
    repeating.timing.retries = 1;
    return repeating;
  }
};

TEST_F(BusLate, ADeviceIsLeftAloneWhileItsAnswerMayStillComeAndOthersGoOn) {
  open(settings());
  submit(job(kRead));
  submit(job_of(1, kOther));
  submit(job_of(1, kRead, 2));
  time_out();
  EXPECT_THAT(frames_, ElementsAre(kReadFrame, kOtherDevice));
  advance(50ms);
  line(kAnswer);  // late: nobody gets it, and the second client has its turn
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_EQ(bus_->counters().late_responses, 1U);
  EXPECT_EQ(bus_->devices()[1].counters.late_responses, 1U);
  EXPECT_EQ(bus_->counters().foreign_frames, 0U);
  advance(60ms);
  EXPECT_THAT(frames_, ElementsAre(kReadFrame, kOtherDevice, kOtherFrame));
}

TEST_F(BusLate, ALateAnswerOnAQuietLineIsSeenToo) {
  open(settings());
  submit(job(kRead));
  time_out();
  advance(10ms);
  line(kAnswer);
  submit(job(kOther));
  EXPECT_EQ(bus_->parts().held_back(1, now_), 0ms);
  EXPECT_EQ(until_next_frame(), kT35);
}

TEST_F(BusLate, TheQuarantineEndsByItself) {
  open(settings());
  submit(job(kRead));
  time_out();
  submit(job(kOther));
  EXPECT_EQ(bus_->parts().held_back(1, now_), 120ms);  // 20 ms for what an adapter still keeps
  EXPECT_EQ(until_next_frame(), 120ms);
}

// Nobody waits so long for it, but its answer may be as late as any.
TEST_F(BusLate, WhatAnOfflineDeviceWasAskedIsOwedAsLongAsWhatOthersWere) {
  auto breaking = settings();
  breaking.timing.offline_after = 1;
  breaking.timing.probe_timeout = 10ms;
  open(breaking);
  submit(job(kRead));
  advance(3s);
  submit(job(kRead));
  advance(kEmission + 10ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::no_answer));
  EXPECT_EQ(bus_->parts().held_back(1, now_), 210ms);
}

TEST_F(BusLate, LatenessIsToldAndTheQuarantineGrows) {
  open(settings());
  submit(job(kRead));
  time_out();
  advance(96ms);
  line(kAnswer);
  ASSERT_THAT(notices_, ElementsAre(Kind::late));
  advance(10ms);
  submit(job(kRead));
  time_out();
  EXPECT_EQ(bus_->parts().held_back(1, now_), 140ms);
}

TEST_F(BusLate, AWriteIsNotTakenForAnsweredByAnOlderAnswer) {
  open(settings());
  submit(job("06 0000 0001"));
  time_out();
  submit(job("06 0000 0001"));
  advance(50ms);
  line("01 06 00 00 00 01 48 0A");
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_THAT(frames_, SizeIs(1));
  advance(10ms);
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(BusLate, ARepeatedWriteWaitsForTheQuarantine) {
  open(repeating());
  submit(job("06 0000 0001"));
  submit(job_of(1, kRead, 2));
  time_out();
  ASSERT_THAT(frames_, SizeIs(2));
  EXPECT_EQ(frames_[1], kOtherDevice);
  advance(20ms);
  line("02 03 02 12 34 F1 33");
  advance(110ms);
  ASSERT_THAT(frames_, SizeIs(3));
  EXPECT_EQ(frames_[2], frames_[0]);
}

TEST_F(BusLate, ARepeatedWriteGoesNoMoreWhenItMayNotBeRepeatedAnyMore) {
  auto changed = repeating();
  open(changed);
  submit(job("06 0000 0001"));
  time_out();
  changed.timing.retry_writes = false;
  update(changed, {});
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  advance(1s);
  EXPECT_THAT(frames_, SizeIs(1));
}

TEST_F(BusLate, WhatWasOnTheWireWhenTheLineWasLostIsStillOwed) {
  open(settings());
  submit(job(kRead));
  bus_->handle_lost(now_);
  drain();
  bus_->handle_opened(now_ + 10ms);
  now_ += 10ms;
  EXPECT_EQ(bus_->parts().held_back(1, now_), kEmission + 210ms);
}

TEST_F(BusLate, ALineThatIsOpenedAgainIsListenedToUntilNothingIsOwed) {
  open(settings());
  submit(job(kRead));
  bus_->handle_lost(now_);
  drain();
  now_ += 10ms;
  bus_->handle_opened(now_);
  drain();
  submit(job(kRead, 2));
  EXPECT_EQ(until_next_frame(), kEmission + 210ms);
}

TEST_F(BusLate, ALineThatIsOpenedAgainWithNothingOwedIsUsedAtOnce) {
  auto listening = settings();
  listening.listen_first = 1s;
  open(listening);
  advance(1s);
  bus_->handle_lost(now_);
  bus_->handle_opened(now_);
  drain();
  submit(job(kRead));
  EXPECT_EQ(until_next_frame(), kT35);
}

TEST_F(BusLate, ABusThatTakesThePortOverLeavesTheDeviceAloneToo) {
  bus::Bus before(settings(), {});
  before.handle_opened(now_);
  now_ += 5ms;
  EXPECT_TRUE(before.submit(job(kRead), now_));
  before.handle_looked(now_);
  const Instant due = now_ + kEmission + 100ms;
  advance(50ms);
  auto renamed = settings();
  renamed.listen_first = 5s;
  bus_.emplace(renamed, std::vector<drive::Device>{});
  bus_->take_over(before, now_);
  bus_->handle_opened(now_);
  drain();
  submit(job(kOther));
  advance(1ms);
  line(kAnswer);
  EXPECT_EQ(bus_->counters().late_responses, 1U);
  advance(1s);
  EXPECT_THAT(frame_times_, ElementsAre(due + 120ms));
}

// A port that is opened again before it was listened to for long enough: the rest is made up for.
TEST_F(BusLate, ABusThatTakesThePortOverListensForTheRestOfItsFirstTime) {
  auto listening = settings();
  listening.listen_first = 500ms;
  bus::Bus before(listening, {});
  before.handle_opened(now_);
  const Instant until = now_ + 500ms;
  advance(100ms);
  bus_.emplace(listening, std::vector<drive::Device>{});
  bus_->take_over(before, now_);
  bus_->handle_opened(now_);
  drain();
  submit(job(kRead));
  advance(1s);
  EXPECT_THAT(frame_times_, ElementsAre(until));
}

// It was no answer to the second write, so that it is closed, and an exception that would fit it
// too is that of the second.
TEST_F(BusLate, WhatCameAlreadyIsNotOwedAnyMore) {
  open(settings());
  submit(job("06 000A 0005"));
  time_out();
  submit(job("06 0014 0007"));
  advance(200ms);
  ASSERT_THAT(frames_, SizeIs(2));
  line("01 06 00 0A 00 05 69 CB");
  advance(5ms);
  line("01 86 03 02 61");
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::answered));
}

// Its length is no response's that is known, but it fits the request.
TEST_F(BusLate, AnAnswerOfAFunctionOfAnyLengthIsLateToo) {
  auto breaking = settings();
  breaking.timing.offline_after = 3;
  open(breaking);
  submit(job("08 0000 1234"));
  time_out();
  submit(job("08 0000 1234"));
  advance(200ms);
  ASSERT_THAT(frames_, SizeIs(2));
  line("01 08 00 00 12 34 ED 7C");
  EXPECT_EQ(bus_->counters().late_responses, 1U);
}

// The driver slept while both came.
TEST_F(BusLate, TwoAnswersInOnePieceToARequestSentOnceAreASecondAnswer) {
  open(settings());
  submit(job(kRead));
  advance(kEmission + 50ms);
  line(std::string(kAnswer) + " " + kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_THAT(notices_, IsEmpty());
  submit(job(kRead));
  advance(99ms);
  EXPECT_THAT(frames_, SizeIs(1));  // a second answer may come so late
  advance(2ms);
  EXPECT_THAT(frames_, SizeIs(2));
}

// Another client asks another device, and is heard. Later it asks this one.
TEST_F(BusLate, SecondAnswersAreNoticedBesideAnotherClient) {
  const auto is_answered_twice = [this] {
    submit(job(kRead));
    advance(10ms);
    line(kAnswer);
    advance(10ms);
    line(kAnswer);
    advance(10ms);
    return bus_->devices()[1].hold.seconds();
  };
  open(settings());
  advance(11s);
  line(kOtherDevice);
  advance(10ms);
  line("02 03 02 12 34 F1 33");
  advance(10ms);
  EXPECT_EQ(is_answered_twice(), 1U);
  EXPECT_THAT(notices_, ElementsAre(Kind::foreign, Kind::second_answer));
  line(kOtherFrame);
  advance(10ms);
  line(kAnswer);
  advance(200ms);
  EXPECT_EQ(is_answered_twice(), 2U);
}

TEST_F(BusLate, OneLostAnswerOfAFastDeviceDelaysAWriteByLittle) {
  auto patient = settings();
  patient.timing.response_timeout = 1s;
  patient.timing.retries = 1;
  open(patient);
  submit(job(kRead));
  advance(kEmission + 5ms);
  line(kAnswer);
  advance(10ms);
  submit(job(kRead));
  advance(kEmission + 1s);
  ASSERT_THAT(frames_, SizeIs(3));
  advance(kEmission + 5ms);
  line(kAnswer);
  submit(job("06 0000 0001"));
  advance(50ms);
  EXPECT_EQ(frames_.back(), "01 06 00 00 00 01 48 0A");
}

}  // namespace
}  // namespace mbgate::test

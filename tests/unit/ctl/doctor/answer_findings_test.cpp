// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "ctl/doctor/findings.hpp"
#include "ctl/doctor/trial.hpp"
#include "line_bytes.hpp"

namespace mbgate::ctl {
namespace {

using std::chrono::microseconds;

constexpr const char* kAllLookAlike =
    "look at power; A and B; the address of the drive; its rate and parity, here 9600 8E1: "
    "mbgatectl scan --device /dev/ttyUSB0 finds those that answer";

std::vector<Trial> good(std::size_t count) {
  return trials(count, answered_after(microseconds(4000)));
}

std::vector<Trial> mixed(std::vector<Trial> some, const std::vector<Trial>& others) {
  some.insert(some.end(), others.begin(), others.end());
  return some;
}

Finding only_finding(std::vector<Trial> of_unit_3) {
  const auto findings = answer_findings(plan_of_line(), {trials_of(3, std::move(of_unit_3))});
  EXPECT_EQ(findings.size(), 1U);
  return findings.front();
}

Finding finding_beside_a_good_one(std::vector<Trial> of_unit_3) {
  return answer_findings(plan_of_line(),
                         {trials_of(3, std::move(of_unit_3)), trials_of(4, good(20))})
      .front();
}

TEST(AnswerFindings, SayHowSoonTheAnswersCome) {
  const auto finding =
      only_finding({answered_after(microseconds(5200)), answered_after(microseconds(4100)),
                    answered_after(microseconds(4500))});
  EXPECT_EQ(finding, (Finding{Judgement::ok, "answers of unit 3",
                              "3 of 3 requests answered, 4.1 ms to 5.2 ms after the request, half "
                              "of them within 4.5 ms"}));
}

TEST(AnswerFindings, TakeAnExceptionForAnAnswer) {
  auto refused = answered_after(microseconds(4000));
  refused.exception = 2;
  const auto finding = only_finding(trials(2, refused));
  EXPECT_EQ(finding,
            (Finding{Judgement::ok, "answers of unit 3",
                     "2 of 2 requests answered, 4.0 ms to 4.0 ms after the request, half "
                     "of them within 4.0 ms, with exception 0x02 (illegal data address)"}));
}

TEST(AnswerFindings, NameAllThatLooksAlikeWhereNobodyAnswers) {
  EXPECT_EQ(only_finding(trials(3, {})),
            (Finding{Judgement::fault, "answers of unit 3",
                     "no answer to 3 requests: not a byte was heard", kAllLookAlike}));
  Trial echoed;
  echoed.echo = true;
  EXPECT_EQ(only_finding(trials(3, echoed)),
            (Finding{Judgement::fault, "answers of unit 3",
                     "no answer to 3 requests: only the request itself was heard", kAllLookAlike}));
}

TEST(AnswerFindings, LookAtTheDriveAloneWhereOthersAnswer) {
  EXPECT_EQ(finding_beside_a_good_one(trials(3, {})),
            (Finding{Judgement::fault, "answers of unit 3",
                     "no answer to 3 requests: not a byte was heard",
                     "look at its power, its address, its wires, its rate and parity"}));
}

TEST(AnswerFindings, SayTheShareOfBadCrcs) {
  const auto some = mixed(good(17), trials(3, {HeardKind::bad_crc}));
  const std::string seen =
      "17 of 20 requests answered, 4.0 ms to 4.0 ms after the request, half of them within 4.0 "
      "ms; 3 with a bad CRC (15 %)";
  const std::string line =
      "look at termination, bias and shield of the line, and at motor cables "
      "beside it";
  EXPECT_EQ(only_finding(some), (Finding{Judgement::fault, "answers of unit 3", seen, line}));
  EXPECT_EQ(finding_beside_a_good_one(some), (Finding{Judgement::fault, "answers of unit 3", seen,
                                                      line + "; or two devices at this address"}));
}

TEST(AnswerFindings, NameRateAndParityWhereOnlyDamageIsHeard) {
  EXPECT_EQ(only_finding(trials(4, {HeardKind::noise})),
            (Finding{Judgement::fault, "answers of unit 3",
                     "no answer to 4 requests: 4 with bytes that are not a frame (100 %)",
                     "rate or parity, here 9600 8E1 (mbgatectl scan --device /dev/ttyUSB0 finds "
                     "those that answer); A and B; two devices at one address"}));
  EXPECT_EQ(finding_beside_a_good_one(trials(4, {HeardKind::bad_crc})),
            (Finding{Judgement::fault, "answers of unit 3",
                     "no answer to 4 requests: 4 with a bad CRC (100 %)",
                     "two devices at this address whose answers overlap, or its own rate, parity, "
                     "wires or transceiver: switch it off, and see whether something still "
                     "answers"}));
}

TEST(AnswerFindings, SayWhatTheTimeoutMustBe) {
  EXPECT_EQ(only_finding(mixed(good(1), {answered_after(microseconds(351'000))})),
            (Finding{Judgement::fault, "answers of unit 3",
                     "2 of 2 requests answered, 4.0 ms to 351.0 ms after the request, half of "
                     "them within 4.0 ms; 1 later than the timeout of 300ms",
                     "set response_timeout to at least 430ms"}));
}

TEST(AnswerFindings, NameTheCausesOfAnotherFrame) {
  EXPECT_EQ(only_finding(trials(3, {HeardKind::other_frame})),
            (Finding{Judgement::fault, "answers of unit 3",
                     "no answer to 3 requests: 3 with a frame that is not the answer",
                     "a device whose answers have another address, function or length than they "
                     "should, or come so late that another request had been sent; or another "
                     "client on this line"}));
}

TEST(AnswerFindings, LeaveTheResponseWaitOutOfTheTimeout) {
  UnitTrials slow{{.address = 3,
                   .timeout = std::chrono::milliseconds(300),
                   .response_wait = std::chrono::milliseconds(100)},
                  {answered_after(microseconds(351'000))}};
  EXPECT_EQ(answer_findings(plan_of_line(), {slow}).front(),
            (Finding{Judgement::fault, "answers of unit 3",
                     "1 of 1 requests answered, 351.0 ms to 351.0 ms after the request, half of "
                     "them within 351.0 ms; 1 later than the timeout of 300ms (with a "
                     "response_wait of 100ms)",
                     "set response_timeout to at least 330ms"}));
}

TEST(AnswerFindings, DoNotTakeTheTimerOfTheAdapterForASlowDevice) {
  auto plan = plan_of_line();
  plan.adapter_delay = std::chrono::milliseconds(16);
  const auto finding_of = [&](microseconds took) {
    return answer_findings(plan, {trials_of(3, mixed(good(1), {answered_after(took)}))}).front();
  };
  EXPECT_EQ(finding_of(microseconds(316'000)),
            (Finding{Judgement::unknown, "answers of unit 3",
                     "2 of 2 requests answered, 4.0 ms to 316.0 ms after the request, half of "
                     "them within 4.0 ms; 1 later than the timeout of 300ms, by no more than the "
                     "16ms of the adapter's timer",
                     "with a timer of 1 ms they may be in time: run this again with it"}));
  EXPECT_EQ(finding_of(microseconds(316'001)).verdict, Judgement::fault);
}

/// As of a device that answers each request after the next one was sent.
std::vector<Trial> one_behind() {
  auto second = answered_after(microseconds(500'000));
  second.after.late_answers = 1;
  second.settled = true;
  return {{}, second, {}, second};
}

TEST(AnswerFindings, SayThatAnswersCameAfterTheNextRequest) {
  EXPECT_EQ(only_finding(one_behind()),
            (Finding{Judgement::fault, "answers of unit 3",
                     "2 of 4 requests answered; 2 not in time; 4 answers came after more than 1s",
                     "set response_timeout to more than 1s, and run this again; or see why the "
                     "device takes so long"}));
  Trial late;
  late.after.late_answers = 1;
  EXPECT_EQ(only_finding({late}).seen,
            "no answer to 1 request in time; 1 answer came after more than 1s");
}

TEST(AnswerFindings, DoubtWhatIsHeardBesideAnotherClient) {
  Trial foreign{HeardKind::other_frame};
  foreign.other_client = "unit 9: read holding registers 0";
  EXPECT_EQ(only_finding({foreign}),
            (Finding{Judgement::unknown, "answers of unit 3",
                     "no answer to 1 request: 1 with a frame that is not the answer",
                     "another client is on this line: disconnect it, and run this again"}));
  auto last = answered_after(microseconds(4000));
  last.after.bytes = 9;
  EXPECT_EQ(only_finding({{HeardKind::noise}, last}).advice,
            "noise or another client is on this line: remove the cause, and run this again");
  EXPECT_EQ(only_finding({last}).verdict, Judgement::ok);
  // It is on the line of each unit.
  const auto both = answer_findings(plan_of_line(), {trials_of(3, {{}}), trials_of(4, {foreign})});
  EXPECT_EQ(both.front().verdict, Judgement::unknown);
}

TEST(Tally, TimesNoAnswerWhileAnEarlierOneIsOwed) {
  const auto times = [](const std::vector<Trial>& trials) {
    return tally_of(trials_of(3, trials)).times;
  };
  const auto early = answered_after(microseconds(1));
  const auto answer = answered_after(microseconds(20));
  auto two = early;
  two.answers = 2;
  auto settled = early;
  settled.settled = true;
  using Times = std::vector<std::chrono::nanoseconds>;
  EXPECT_EQ(times({{}, early, early}), Times());
  EXPECT_EQ(times({{}, {}, two, early, answer}), Times());
  EXPECT_EQ(times({{}, two, answer}), Times{microseconds(20)});
  EXPECT_EQ(times({{}, settled, answer}), Times{microseconds(20)});
  // What was damaged has come.
  EXPECT_EQ(times({{HeardKind::bad_crc}, answer}), Times{microseconds(20)});
}

TEST(Tally, KnowsHowManyAnswersAreOwed) {
  EXPECT_EQ(owed_answers({}), 0U);
  EXPECT_EQ(owed_answers(trials(3, {})), 3U);
  EXPECT_EQ(owed_answers(mixed(trials(2, {}), good(5))), 2U);
  EXPECT_EQ(owed_answers(one_behind()), 0U);
}

TEST(Tally, CountsAnswersThatCameAfterTheNextRequest) {
  const auto tally = tally_of(trials_of(3, one_behind()));
  EXPECT_EQ(tally.overdue, 4U);
  EXPECT_EQ(tally.times, std::vector<std::chrono::nanoseconds>());
}

TEST(Tally, GivesAUnitUpThatWasSilentThreeTimesInARow) {
  EXPECT_FALSE(is_given_up(trials(2, {})));
  EXPECT_TRUE(is_given_up(trials(3, {})));
  EXPECT_FALSE(is_given_up(mixed(trials(3, {}), good(1))));
  EXPECT_TRUE(is_given_up(mixed(good(1), trials(3, {}))));
}

TEST(Tally, GivesAUnitUpThatWasNeverUnderstood) {
  const Trial noise{HeardKind::noise};
  EXPECT_FALSE(is_given_up(trials(4, noise)));
  EXPECT_TRUE(is_given_up(trials(5, noise)));
  EXPECT_FALSE(is_given_up(mixed(good(1), trials(5, noise))));
  Trial late;
  late.after.late_answers = 1;
  EXPECT_FALSE(is_given_up(trials(5, late)));
}

}  // namespace
}  // namespace mbgate::ctl

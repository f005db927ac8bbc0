// SPDX-License-Identifier: Apache-2.0
#include "ctl/doctor/answer_findings.hpp"

#include <gtest/gtest.h>

#include "ctl/doctor/tally.hpp"
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
                     "no answer to 4 requests: 4 with bytes that are no frame (100 %)",
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
                     "a device that answers with another address, or so late that another request "
                     "was sent before; or another client on this line"}));
}

TEST(Tally, DoesNotTimeAnAnswerThatMayBeToTheRequestBefore) {
  const auto tally = tally_of(trials_of(3, {answered_after(microseconds(10)),
                                            {},
                                            answered_after(microseconds(1)),
                                            answered_after(microseconds(20))}));
  EXPECT_EQ(tally.answered, 3U);
  EXPECT_EQ(tally.silent, 1U);
  EXPECT_EQ(tally.times,
            (std::vector<std::chrono::nanoseconds>{microseconds(10), microseconds(20)}));
}

TEST(Tally, GivesAUnitUpThatWasSilentThreeTimesInARow) {
  EXPECT_FALSE(is_given_up(trials(2, {})));
  EXPECT_TRUE(is_given_up(trials(3, {})));
  EXPECT_FALSE(is_given_up(mixed(trials(3, {}), good(1))));
  EXPECT_TRUE(is_given_up(mixed(good(1), trials(3, {}))));
  EXPECT_FALSE(is_given_up(trials(3, {HeardKind::noise})));
}

}  // namespace
}  // namespace mbgate::ctl

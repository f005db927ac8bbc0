// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include "ctl/doctor/findings.hpp"
#include "line_bytes.hpp"

namespace mbgate::ctl {
namespace {

using std::chrono::microseconds;

Trial with_echo() {
  auto trial = answered_after(microseconds(4000));
  trial.echo = true;
  return trial;
}

Trial without_echo() { return answered_after(microseconds(4000)); }

Finding echo_of(std::optional<bool> configured, std::vector<Trial> of_unit_3) {
  auto plan = plan_of_line();
  plan.echo = configured;
  return echo_finding(plan, {trials_of(3, std::move(of_unit_3))});
}

TEST(EchoFinding, IsAFaultOnlyWhereTheConfigurationSaysOtherwise) {
  EXPECT_EQ(echo_of(std::nullopt, trials(2, without_echo())),
            (Finding{Judgement::ok, "echo", "no request came back to the port"}));
  const std::string heard =
      "the port receives what it sends: each request came back before its answer";
  EXPECT_EQ(echo_of(std::nullopt, trials(2, with_echo())),
            (Finding{Judgement::ok, "echo", heard,
                     R"(with echo = "auto" the gateway detects this, with echo = true it knows)"}));
  EXPECT_EQ(echo_of(true, trials(2, with_echo())), (Finding{Judgement::ok, "echo", heard}));
  EXPECT_EQ(echo_of(false, trials(2, with_echo())),
            (Finding{Judgement::fault, "echo", heard + ", and the bus has echo = false",
                     R"(set echo = true or "auto")"}));
}

TEST(EchoFinding, SaysThatNothingButTheRequestsCameBack) {
  Trial trial;
  trial.echo = true;
  EXPECT_EQ(echo_of(true, trials(2, trial)),
            (Finding{Judgement::ok, "echo",
                     "the port receives what it sends: each request came back, and no answer "
                     "after it"}));
}

TEST(EchoFinding, MissesAnEchoOnlyWhereSomethingIsHeard) {
  const std::string seen = "no request came back to the port, but the bus has echo = true";
  EXPECT_EQ(echo_of(true, trials(2, without_echo())),
            (Finding{Judgement::fault, "echo", seen, R"(set echo = false or "auto")"}));
  EXPECT_EQ(echo_of(true, trials(2, {})), (Finding{Judgement::unknown, "echo", seen,
                                                   "no valid frame was received on this line"}));
}

TEST(EchoFinding, SaysThatSomeRequestsDidNotComeBack) {
  EXPECT_EQ(echo_of(true, {with_echo(), with_echo(), without_echo()}),
            (Finding{Judgement::fault, "echo",
                     "2 of 3 requests came back as they were sent, the others did not",
                     "look for another client that sends at the same time, and for an adapter that "
                     "loses bytes"}));
}

Trial doubled() {
  auto trial = answered_after(microseconds(4000));
  trial.answers = 2;
  return trial;
}

std::vector<Trial> followed(std::vector<Trial> trials, const Trial& last) {
  trials.push_back(last);
  return trials;
}

TEST(AddressesFinding, NeedsTwoAnswersTwice) {
  EXPECT_EQ(addresses_finding({trials_of(3, trials(20, without_echo()))}),
            (Finding{Judgement::ok, "addresses", "no request had a second answer"}));
  EXPECT_EQ(
      addresses_finding({trials_of(3, followed(trials(19, without_echo()), doubled()))}),
      (Finding{Judgement::unknown, "addresses", "1 of 20 requests to unit 3 had two whole answers",
               "run this again: one may be a late answer to an earlier request"}));
  EXPECT_EQ(
      addresses_finding(
          {trials_of(4, trials(20, without_echo())), trials_of(3, trials(20, doubled()))}),
      (Finding{Judgement::fault, "addresses",
               "20 of 20 requests to unit 3 had two whole answers, and no request but ours "
               "was heard",
               "two devices at address 3, or another client whose requests are not heard "
               "here, or an adapter that receives what it sends: switch the device off, and see "
               "whether something still answers"}));
}

TEST(AddressesFinding, ClaimsNothingWhereAnotherClientAsks) {
  auto foreign = without_echo();
  foreign.other_client = "unit 9: read holding registers 0";
  EXPECT_EQ(addresses_finding({trials_of(3, followed(trials(2, doubled()), foreign))}),
            (Finding{Judgement::unknown, "addresses",
                     "2 of 3 requests to unit 3 had two whole answers, but another client asks on "
                     "this line too",
                     "disconnect the other client, and run this again"}));
}

TEST(AddressesFinding, ClaimsNothingWhereSomethingElseIsOnTheLine) {
  auto last = without_echo();
  last.after.bytes = 9;
  EXPECT_EQ(addresses_finding({trials_of(3, followed(trials(2, doubled()), last))}),
            (Finding{Judgement::unknown, "addresses",
                     "2 of 3 requests to unit 3 had two whole answers, but other bytes came on "
                     "this line without a request",
                     "remove the cause, and run this again"}));
}

TEST(AddressesFinding, CountsASecondAnswerThatCameLater) {
  auto later = without_echo();
  later.after.late_answers = 1;
  EXPECT_EQ(addresses_finding({trials_of(3, trials(2, later))}).verdict, Judgement::fault);
}

TEST(ForeignFinding, NamesTheOtherClientByItsRequest) {
  const Finding expected{Judgement::fault, "other client",
                         "a request of another client was heard: unit 9: read holding registers 0; "
                         "no more requests were sent",
                         kOneClient};
  const std::string request = "unit 9: read holding registers 0";
  auto within = without_echo();
  within.other_client = request;
  EXPECT_EQ(foreign_finding({}, {trials_of(3, {without_echo(), within})}), expected);
  auto behind = without_echo();
  behind.after.other_client = request;
  EXPECT_EQ(foreign_finding({}, {trials_of(3, {behind})}), expected);
  EXPECT_EQ(foreign_finding({.other_client = request}, {}), expected);
}

TEST(ForeignFinding, NamesAllCausesOfBytesBetweenRequests) {
  auto disturbed = without_echo();
  disturbed.after.bytes = 9;
  EXPECT_EQ(foreign_finding({}, {trials_of(3, {disturbed})}),
            (Finding{Judgement::fault, "between requests",
                     "9 bytes came without a request; no more requests were sent",
                     "looks like noise (termination, bias, shield, motor cables beside it), or "
                     "like another client, maybe at another rate or parity"}));
  EXPECT_EQ(foreign_finding({}, {trials_of(3, {without_echo()})}), std::nullopt);
  EXPECT_EQ(foreign_finding({}, {}), std::nullopt);
}

TEST(AddressesFinding, DoesNotCountAnAnswerThatMayBeToTheRequestBefore) {
  EXPECT_EQ(addresses_finding({trials_of(3, {{}, doubled(), {}, {}, doubled()})}),
            (Finding{Judgement::ok, "addresses", "no request had a second answer"}));
}

TEST(AddressesFinding, NamesAllCausesOfAnswersThatAreAlwaysDamaged) {
  Trial damaged{HeardKind::bad_crc};
  damaged.bytes = 9;
  EXPECT_EQ(addresses_finding(
                {trials_of(3, trials(20, damaged)), trials_of(4, trials(20, without_echo()))}),
            (Finding{Judgement::unknown, "addresses",
                     "each answer of unit 3 is damaged (up to 9 bytes), while others answer well: "
                     "two devices whose answers overlap look like this, and so does a device with "
                     "a wrong rate or parity, bad wires or a bad transceiver",
                     "switch it off: if something still answers, there is a second one"}));
  EXPECT_EQ(addresses_finding({trials_of(3, trials(20, damaged))}),
            (Finding{Judgement::unknown, "addresses", "no answer was understood"}));
}

}  // namespace
}  // namespace mbgate::ctl

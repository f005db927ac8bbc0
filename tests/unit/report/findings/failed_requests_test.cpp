// SPDX-License-Identifier: Apache-2.0
// Requests that fail though no line and no device is at fault.
#include "unit/report/findings/trouble.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// Each write comes back as it was sent, and the drive has said nothing else.
TEST(LineThatMayHaveAnEcho, IsNamedAndNotTheBytesThatCame) {
  Settings settings = troubled_plant();
  settings.buses[0].line.echo.reset();
  Trouble trouble(settings);
  for (int times = 0; times < 12; ++times) {
    trouble.rig.receive(1, "00 01 00 00 00 06 01 06 00 00 00 01");
    trouble.rig.advance(10ms);
    trouble.rig.respond("01 06 00 00 00 01");
    trouble.rig.advance(20s);
  }
  EXPECT_THAT(trouble.diagnoses(),
              ElementsAre("bus line-a: it is not known whether the adapter receives what it sends "
                          "| a write came back unchanged, which acknowledges nothing: such writes "
                          "get 0B | set `echo = false`, or `echo = true` if it does; or read from "
                          "the drive"));
}

TEST(FailedRequests, AreNamedWhereNothingElseExplainsThem) {
  Settings settings = troubled_plant();
  settings.listeners[0].max_requests_per_second = 2;
  Trouble trouble(settings);
  trouble.read("");
  for (int times = 0; times < 6; ++times) {
    trouble.rig.receive(1, read_request(1));
  }
  trouble.rig.respond(kAnswerOfAxis);
  EXPECT_THAT(trouble.diagnoses(),
              ElementsAre("listener plant: 71 % of its requests fail | 5 of the last 7; the last "
                          "one got exception 0x06 (server device busy) | TIMEOUTS of the devices; "
                          "the journal says what was refused, and why"));
  trouble.rig.advance(1min);
  EXPECT_THAT(trouble.diagnoses(), IsEmpty());
}

TEST(FailedRequests, AreNotNamedWhereFewerThanOneInAHundredFail) {
  Settings settings = troubled_plant();
  settings.listeners[0].max_requests_per_second = 2;
  Trouble trouble(settings);
  for (int times = 1; times <= 1500; ++times) {
    trouble.read("");
    if (times % 150 == 0) {
      trouble.rig.receive(1, read_request(1));
      trouble.rig.receive(1, read_request(1));
      trouble.rig.respond(kAnswerOfAxis);
    }
    EXPECT_THAT(trouble.diagnoses(), IsEmpty()) << times;
    trouble.rig.advance(2s);
  }
}

constexpr auto kGivenUp =
    "listener plant: 100 % of its requests fail | 4 of the last 4; the last one got no answer "
    "before "
    "its client gave up | the timeout of the client, and the times of the devices";

TEST(FailedRequests, AreThoseTooThatNobodyWaitedFor) {
  Settings settings = troubled_plant();
  settings.listeners[0].give_up = 50ms;
  Trouble trouble(settings);
  for (int times = 0; times < 4; ++times) {
    trouble.rig.receive(1, read_request(1));
    trouble.rig.advance(70ms);
    trouble.rig.respond(kAnswerOfAxis);
    trouble.rig.advance(1s);
  }
  EXPECT_THAT(trouble.diagnoses(), ElementsAre(kGivenUp));
}

TEST(FailedRequests, AreThoseTooWhoseClientHasGone) {
  Trouble trouble(troubled_plant());
  for (std::uint64_t client = 2; client < 6; ++client) {
    trouble.rig.connect(client);
    trouble.rig.receive(client, read_request(1));
    trouble.rig.advance(50ms);
    trouble.rig.disconnect(client);
    trouble.rig.advance(10ms);
    trouble.rig.respond(kAnswerOfAxis);
    trouble.rig.advance(2min);
  }
  EXPECT_THAT(trouble.diagnoses(), ElementsAre(kGivenUp));
}

}  // namespace
}  // namespace mbgate::test

// SPDX-License-Identifier: Apache-2.0
// Troubles that change: silence between damaged answers, an echo that is gone, another device at an
// address. What is said must be true of now.
#include "unit/report/findings/trouble.hpp"

namespace mbgate::test {
namespace {

using gateway::DeviceStatus;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;

constexpr auto kDamagedAnswer = "01 03 02 12 35 B5 33";
constexpr auto kOwnEcho = "01 03 00 00 00 01 84 0A";

void ask_silent(Trouble& trouble, int times, unsigned unit = 1) {
  for (int at = 0; at < times; ++at) {
    trouble.rig.receive(1, read_request(1, unit));
    trouble.rig.advance(430ms);
  }
}

DeviceStatus first_device(Trouble& trouble) {
  return trouble.rig.harness.gateway().report_status(60s, trouble.rig.now()).devices.at(0);
}

TEST(DamagedAnswersAmongTimeouts, AreNoSilence) {
  Trouble trouble;
  for (int at = 0; at < 5; ++at) {
    trouble.read_in_vain(1, kDamagedAnswer);
    ask_silent(trouble, 1);
  }
  EXPECT_THAT(trouble.diagnoses(),
              ElementsAre("device axis: bad CRC in 100 % of its answers | 5 of 5 | termination, "
                          "bias, cable, or two devices at one address"));
}

TEST(DamagedAnswersAmongTimeouts, BeginTheSilenceAnew) {
  Trouble trouble;
  ask_silent(trouble, 2);
  trouble.read_in_vain(1, kDamagedAnswer);
  ask_silent(trouble, 3);
  EXPECT_THAT(trouble.diagnoses(),
              ElementsAre(std::string("bus line-a: nothing answers | 3 transmissions in a row to 1 "
                                      "device unanswered, and nothing else heard | ") +
                          kCausesOfNoAnswer));
}

TEST(OneRequest, IsADisturbanceHoweverOftenItIsRepeated) {
  Settings settings = troubled_plant();
  settings.devices[0].timing.retries = 2;
  Trouble trouble(settings);
  ask_silent(trouble, 1);
  EXPECT_EQ(first_device(trouble).unanswered_in_row, 3U);
  EXPECT_THAT(trouble.diagnoses(), IsEmpty());
  ask_silent(trouble, 1);
  EXPECT_THAT(trouble.diagnoses(),
              ElementsAre(std::string("bus line-a: nothing answers | 6 transmissions in a row to 1 "
                                      "device unanswered, and nothing else heard | ") +
                          kCausesOfNoAnswer));
}

TEST(OneRequest, ThatMadeADriveOfflineIsTold) {
  Settings settings = troubled_plant();
  settings.devices[0].timing.retries = 2;
  settings.devices[0].timing.offline_after = 3;
  Trouble trouble(settings);
  ask_silent(trouble, 1);
  EXPECT_EQ(trouble.diagnoses().size(), 1U);
}

TEST(LateAnswer, IsTheLastOneThatCame) {
  Trouble trouble;
  ask_silent(trouble, 1);
  EXPECT_EQ(first_device(trouble).last_answer, std::nullopt);
  trouble.rig.respond(kAnswerOfAxis);
  trouble.rig.advance(2s);
  const DeviceStatus axis = first_device(trouble);
  EXPECT_TRUE(axis.has_answered);
  EXPECT_EQ(axis.last_answer, Duration{2s});
}

TEST(DeniedEcho, IsOverOnceAReadIsAnsweredWithoutIt) {
  Trouble trouble;
  trouble.read(kOwnEcho);
  trouble.read(kOwnEcho);
  ASSERT_THAT(trouble.diagnoses(), SizeIs(1));
  trouble.read("");
  EXPECT_THAT(trouble.diagnoses(), IsEmpty());
}

// Each may be a request of another client that asked for the same.
TEST(DeniedEcho, IsNotProvenByTwoThatAreFarApart) {
  Trouble trouble;
  trouble.read(kOwnEcho);
  trouble.rig.advance(2min);
  trouble.read(kOwnEcho);
  EXPECT_THAT(trouble.diagnoses(), IsEmpty());
  trouble.read(kOwnEcho);
  EXPECT_THAT(trouble.diagnoses(), SizeIs(1));
}

TEST(AnotherDevice, IsNotWhatTheOneBeforeItWas) {
  Settings settings = troubled_plant();
  Trouble trouble(settings);
  trouble.read("");
  ask_silent(trouble, 3);
  trouble.rig.reload(settings);
  ASSERT_THAT(trouble.diagnoses(),
              ElementsAre(StartsWith("device axis: it does not answer any more | 3 ")));
  settings.devices[0].name = "crane";
  trouble.rig.reload(settings);
  EXPECT_THAT(trouble.diagnoses(), IsEmpty());
  const DeviceStatus crane = first_device(trouble);
  EXPECT_EQ(crane.name, "crane");
  EXPECT_EQ(crane.state, DeviceStatus::State::not_asked);
  EXPECT_EQ(crane.state_since, std::nullopt);
  EXPECT_FALSE(crane.has_answered);
  EXPECT_EQ(crane.last_request, std::nullopt);
  EXPECT_EQ(crane.last_answer, std::nullopt);
  EXPECT_EQ(crane.quality.quality, bus::Quality::unknown);
  EXPECT_EQ(crane.times.device.lately().percentile(50), std::nullopt);
  ask_silent(trouble, 3);
  EXPECT_THAT(trouble.diagnoses(), ElementsAre(StartsWith("bus line-a: nothing answers | 3 ")));
}

TEST(AnotherDevice, IsNotOneOfTwoThatGaveTwoAnswers) {
  Settings settings = troubled_plant();
  Trouble trouble(settings);
  trouble.rig.advance(20s);
  trouble.read("");
  trouble.rig.respond(kAnswerOfAxis);
  trouble.rig.advance(3s);
  ASSERT_THAT(trouble.diagnoses(), SizeIs(1));
  settings.devices[0].name = "crane";
  trouble.rig.reload(settings);
  trouble.read("");
  EXPECT_THAT(trouble.diagnoses(), IsEmpty());
}

// Perhaps the route that led there is gone.
TEST(AddressWithoutADevice, IsOnlyNamedIfItWasAskedSinceTheReload) {
  const Settings settings = troubled_plant();
  Trouble trouble(settings);
  trouble.read("");
  ask_silent(trouble, 3, 9);
  ASSERT_THAT(trouble.diagnoses(),
              ElementsAre(StartsWith("bus line-a address 9: it has never answered | 3 ")));
  trouble.rig.reload(settings);
  EXPECT_THAT(trouble.diagnoses(), IsEmpty());
  ask_silent(trouble, 1, 9);
  EXPECT_THAT(trouble.diagnoses(),
              ElementsAre(StartsWith("bus line-a address 9: it has never answered | 4 ")));
}

}  // namespace
}  // namespace mbgate::test

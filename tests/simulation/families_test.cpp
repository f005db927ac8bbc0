// SPDX-License-Identifier: Apache-2.0
// Drives of four makers behind one gateway: what clients see, and what the drives hold.
#include "simulation/families.hpp"

namespace mbgate::test {
namespace {

TEST_F(Families, EveryUnitShowsItsValuesHighWordFirst) {
  build();
  constexpr std::uint32_t kValue = 200000;  // 0x00030D40
  for (const unsigned unit : {kM3, kM3Big}) {
    EXPECT_EQ(ask(unit, "10 016C 0002 04 0003 0D40"), "10 01 6C 00 02");  // homing offset
    EXPECT_EQ(device(unit).drive<sim::MoonsDrive>()->registers().get(0x016C), kValue);
    EXPECT_EQ(ask(unit, "03 016C 0002"), "03 04 00 03 0D 40");
    EXPECT_EQ(ask(unit, "03 016D 0001"), "03 02 0D 40");
  }
  EXPECT_EQ(ask(kStepper, "10 00D8 0002 04 0003 0D40"), "10 00 D8 00 02");  // speed
  EXPECT_EQ(device(kStepper).drive<sim::StepperDrive>()->registers().get(0x00D8), kValue);
  EXPECT_EQ(ask(kStepper, "03 00D8 0002"), "03 04 00 03 0D 40");
  EXPECT_EQ(ask(kStepper, "04 00D9 0001"), "04 02 0D 40");
  EXPECT_EQ(ask(kAic, "10 0002 0002 04 0003 0D40"), "10 00 02 00 02");  // start speed
  EXPECT_EQ(device(kAic).drive<sim::AicDrive>()->bank(modbus::Table::holding_registers).get(2),
            kValue);
  EXPECT_EQ(ask(kAic, "03 0002 0002"), "03 04 00 03 0D 40");
  EXPECT_EQ(ask(kFda, "06 00C8 0123"), "06 00 C8 01 23");
  EXPECT_EQ(ask(kFda, "03 00C8 0001"), "03 02 01 23");
}

TEST_F(Families, HalfAValueIsWrittenWhereTheDriveHasIt) {
  build();
  for (const unsigned unit : {kM3, kM3Big}) {
    EXPECT_EQ(ask(unit, "06 016C 0003"), "06 01 6C 00 03");
    EXPECT_EQ(ask(unit, "06 016D 0D40"), "06 01 6D 0D 40");
    EXPECT_EQ(device(unit).drive<sim::MoonsDrive>()->registers().get(0x016C), 200000U);
  }
}

TEST_F(Families, AValueThatStartsMotionIsWrittenWhole) {
  build();
  EXPECT_EQ(ask(kStepper, "06 00D0 0001"), "86 03");
  EXPECT_EQ(ask(kStepper, "06 00D1 0001"), "86 03");
  EXPECT_EQ(frames(), 0U);
  EXPECT_EQ(ask(kStepper, "10 00D0 0002 04 0000 2710"), "10 00 D0 00 02");
}

TEST_F(Families, ALongReadOfAMoonsDriveIsOneAnswer) {
  build();
  const std::string answer = ask(kM3, "03 0000 007D");
  EXPECT_EQ(answer.substr(0, 5), "03 FA");
  EXPECT_EQ(frames(), 3U);
  const std::string same = ask(kM3Big, "03 0000 007D");
  EXPECT_EQ(answer, same);  // two drives in the same state, whatever their word order
}

// Drives of one make hold the same state behind the two orders, whatever was written how.
TEST_F(Families, TwoWordOrdersGiveTheSameTraffic) {
  build();
  std::mt19937 random(3);
  const auto& values = settings_.devices[0].profile.values.all();
  constexpr unsigned kPr = 0x0120;  // 40289: the word order itself, the one value that must differ
  for (int step = 0; step < 400; ++step) {
    const auto& value = values[random() % values.size()];
    if (value.first == kPr) {
      continue;
    }
    char text[64];
    std::snprintf(text, sizeof text, "10 %04X 0002 04 %04X %04X", unsigned{value.first},
                  static_cast<unsigned>(random() & 3U), static_cast<unsigned>(random() & 0xFFFFU));
    EXPECT_EQ(ask(kM3, text), ask(kM3Big, text)) << text;
    const auto first = static_cast<unsigned>(random() % 580);
    const auto count = static_cast<unsigned>(1 + random() % 9);
    if (first > kPr + 1 || first + count <= kPr) {
      std::snprintf(text, sizeof text, "03 %04X %04X", first, count);
      EXPECT_EQ(ask(kM3, text), ask(kM3Big, text)) << text;
    }
    EXPECT_EQ(device(kM3).drive<sim::MoonsDrive>()->registers().get(value.first),
              device(kM3Big).drive<sim::MoonsDrive>()->registers().get(value.first));
  }
  EXPECT_EQ(world_->silence_violations(), 0U);
}

TEST_F(Families, TheAicNeverSeesARequestAcrossItsParameterGroups) {
  build();
  // Outputs, then commands, which cannot be read: what the drive itself says to that, not 03.
  EXPECT_EQ(ask(kAic, "01 0000 001B"), "81 02");
  EXPECT_EQ(frames(), 2U);
  // A write is not split unasked, and does not go out to be refused.
  EXPECT_EQ(ask(kAic, "10 000A 002A 54" + std::string(84 * 2, '0')), "90 03");
  EXPECT_EQ(frames(), 2U);
}

TEST_F(Families, ARestartIsAnsweredByTheGatewayAndHoldsOnlyThatDriveBack) {
  build();
  const Instant asked = world_->now();
  EXPECT_EQ(ask(kStepper, "06 00D4 0100"), "06 00 D4 01 00");
  EXPECT_LT(world_->now() - asked, 110ms);  // the turnaround delay
  const Instant restarted = world_->now();
  send(kStepper, "03 00D8 0002");
  EXPECT_EQ(ask(kM3, "03 0001 0001").substr(0, 5), "03 02");
  EXPECT_LT(world_->now() - restarted, 20ms);
  world_->run(restarted + 10s, [this] { return !answers_.empty(); });
  EXPECT_GE(world_->now() - restarted, 2800ms);
  EXPECT_EQ(std::exchange(answers_, {}).at(0).substr(0, 5), "03 04");
  // Enable and release at the same register answer as usual.
  const Instant released = world_->now();
  EXPECT_EQ(ask(kStepper, "06 00D4 0001"), "06 00 D4 00 01");
  EXPECT_LT(world_->now() - released, 20ms);
}

TEST_F(Families, ABroadcastRestartHoldsBackWhoBoots) {
  // An M3 has half a value where the stepper has its restart: no such broadcast would go out.
  settings_.devices[kM3 - 1].profile.values = {};
  settings_.devices[kM3Big - 1].profile.values = {};
  for (auto& route : settings_.routes) {
    route.broadcast_mixed = true;  // nor where drives of several makers listen
  }
  build();
  EXPECT_EQ(ask(0, "06 00D4 0100"), "06 00 D4 01 00");
  const Instant restarted = world_->now();
  send(kStepper, "03 00D8 0002");
  EXPECT_EQ(ask(kAic, "03 0006 0001").substr(0, 5), "03 02");
  EXPECT_LT(world_->now() - restarted, 300ms);
  world_->run(restarted + 10s, [this] { return !answers_.empty(); });
  EXPECT_GE(world_->now() - restarted, 2800ms);
  EXPECT_EQ(std::exchange(answers_, {}).at(0).substr(0, 5), "03 04");
}

TEST_F(Families, ASaveTakesItsTime) {
  build();
  const Instant asked = world_->now();
  EXPECT_EQ(ask(kStepper, "06 00DC 0001"), "06 00 DC 00 01");
  EXPECT_GT(world_->now() - asked, 100ms);  // twice the response timeout of the drive
  EXPECT_EQ(frames(), 1U);
}

TEST_F(Families, OneBroadcastReachesEveryKindInItsOwnForm) {
  build();
  ASSERT_EQ(ask(kAic, "06 0006 0064"), "06 00 06 00 64");
  const auto before = frames();
  const Instant asked = world_->now();
  EXPECT_EQ(ask(0, "05 000B FF00"), "05 00 0B FF 00");  // emergency stop of every AiC
  world_->run_for(5ms);                                 // the silence that ends the frame
  EXPECT_EQ(frames(), before + 1);
  EXPECT_EQ(hex(world_->wire(0).frames().back().bytes).substr(0, 17), "81 85 00 0B FF 00");
  EXPECT_EQ(world_->wire(0).frames().back().heard_by, std::vector<std::uint8_t>{17});
  EXPECT_EQ(ask(kM3, "03 0001 0001").substr(0, 5), "03 02");
  EXPECT_GE(world_->now() - asked, 100ms);  // the turnaround delay
  EXPECT_EQ(world_->silence_violations(), 0U);
}

TEST_F(Families, VendorFunctionsAreCarriedAsTheyAre) {
  build();
  for (const auto* const function : {"46", "47", "48", "49", "4A", "50"}) {
    const std::string request = std::string(function) + " 00 01 00 02";
    EXPECT_EQ(ask(kFda, request), request);
  }
}

}  // namespace
}  // namespace mbgate::test

// SPDX-License-Identifier: Apache-2.0
// The line side alone: what lines bring, and what becomes of what buses decide.
#include <gmock/gmock.h>

#include "gateway/lines.hpp"
#include "modbus/frames.hpp"
#include "support/action_text.hpp"
#include "unit/gateway/parts_plant.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::StartsWith;

class LinesAlone : public testing::Test {
 protected:
  /// What is to be done at the lines, then what is told.
  std::vector<std::string> taken(Instant now) {
    while (lines_.serve_one(now)) {
    }
    std::vector<std::string> all;
    while (const auto action = lines_.poll_action()) {
      all.push_back(action_text(*action, settings_.settings()));
    }
    while (const auto action = actions_.poll()) {
      all.push_back(action_text(*action, settings_.settings()));
    }
    return all;
  }
  void open() {
    lines_.handle(gateway::LineOpened{BusId{0}}, Instant{});
    taken(Instant{});
  }
  /// A request for a register of unit 1.
  std::uint32_t ask(Instant now) {
    const auto* route = settings_.in_force().routes.find(ListenerId{0}, 1);
    const std::uint32_t index = exchanges_.open(std::nullopt);
    gateway::Exchange& exchange = exchanges_[index];
    exchange.route = route;
    exchange.header = {1, 1};
    exchange.plan = *routing::Plan::make(*route, 1, {}, *modbus::Pdu::from(unhex("03 0000 0001")));
    exchange.arrival = now;
    exchanges_[index].deadline = exchanges_.deadline_of(exchanges_[index]);
    exchanges_.start(index, {}, now);
    return index;
  }

  SettingsHistory settings_{stop_plant()};
  ActionQueue actions_;
  gateway::TraceBook trace_{settings_};
  gateway::Exchanges exchanges_{settings_, buses_, actions_};
  gateway::BusSet buses_{settings_.settings()};
  gateway::Lines lines_{buses_, exchanges_, trace_, actions_};
};

TEST_F(LinesAlone, AreToBeOpenedAndItIsToldWhenTheyAre) {
  EXPECT_THAT(taken(Instant{}), ElementsAre("bus line-a: open the line"));
  lines_.handle(gateway::LineOpened{BusId{0}}, Instant{});
  EXPECT_THAT(taken(Instant{}), ElementsAre("bus line-a is open"));
  EXPECT_FALSE(lines_.has_actions());
  EXPECT_FALSE(lines_.serve_one(Instant{}));
}

TEST_F(LinesAlone, AreLookedAtBeforeARequestIsTransmittedAndItsAnswerEndsIt) {
  open();
  const std::uint32_t index = ask(Instant{10ms});
  EXPECT_THAT(taken(Instant{10ms}), ElementsAre("bus line-a: look at the line"));
  lines_.handle(gateway::LineLooked{BusId{0}}, Instant{10ms});
  EXPECT_THAT(taken(Instant{10ms}), ElementsAre(StartsWith("bus line-a > ")));
  EXPECT_EQ(exchanges_.take_completed(), std::nullopt);
  const auto answer = modbus::encode_rtu(1, *modbus::Pdu::from(unhex("03 02 0007")));
  lines_.handle(gateway::LineBytes{BusId{0}, {answer.data(), answer.size()}}, Instant{30ms});
  EXPECT_THAT(taken(Instant{30ms}), IsEmpty());
  ASSERT_EQ(exchanges_.take_completed(), index);
  EXPECT_FALSE(exchanges_[index].result()->is_exception());
}

TEST_F(LinesAlone, OneThatIsLostEndsWhatWaitsForIt) {
  open();
  const std::uint32_t index = ask(Instant{10ms});
  taken(Instant{10ms});
  lines_.handle(gateway::LineLost{BusId{0}}, Instant{20ms});
  EXPECT_THAT(taken(Instant{20ms}), ElementsAre("bus line-a is lost; it is being reopened"));
  EXPECT_EQ(exchanges_.take_completed(), index);
}

TEST_F(LinesAlone, OneThatAReloadHasChangedIsClosedAndOpenedAndNothingIsTold) {
  open();
  const std::uint32_t index = ask(Instant{10ms});
  taken(Instant{10ms});
  Settings changed = stop_plant();
  changed.buses[0].line.device = "/dev/ttyS1";
  const gateway::SettingsSnapshot& before = settings_.adopt(changed);
  lines_.adopt(before.settings, settings_.settings(), Instant{20ms});
  EXPECT_TRUE(lines_.has_actions());
  EXPECT_THAT(taken(Instant{20ms}),
              ElementsAre("bus line-a: close the line", "bus line-a: open the line"));
  EXPECT_EQ(exchanges_.take_completed(), index);
}

}  // namespace
}  // namespace mbgate::test

// SPDX-License-Identifier: Apache-2.0
// What the status says of lines, drives and clients, and what it calls wrong.
#include <gmock/gmock.h>

#include "report/findings/diagnosis.hpp"
#include "support/machine_rig.hpp"
#include "unit/report/findings/trouble.hpp"

namespace mbgate::test {
namespace {

using gateway::DeviceStatus;
using testing::ElementsAre;
using testing::IsEmpty;

Settings axis_and_lift() {
  Settings settings = one_bus();
  settings.buses[0].timing.retries = 0;
  settings.devices = {{"axis", BusId{0}, 1, settings.buses[0].timing},
                      {"lift", BusId{0}, 2, settings.buses[0].timing}};
  return settings;
}

class StatusOfAPlant : public testing::Test {
 protected:
  StatusOfAPlant() { rig_.connect(1, "192.0.2.7"); }
  [[nodiscard]] gateway::StatusReport report() {
    return rig_.harness.gateway().report_status(60s, rig_.now());
  }
  [[nodiscard]] std::vector<std::string> diagnoses() {
    std::vector<std::string> all;
    for (const auto& it : report::diagnose(report())) {
      all.push_back(it.subject + ": " + it.finding + " | " + it.evidence + " | " + it.look_at);
    }
    return all;
  }
  void ask(unsigned unit = 1) {
    rig_.receive(1, read_request(1, unit));
    rig_.advance(30ms);
  }
  void ask_and_answer(unsigned unit = 1) {
    ask(unit);
    rig_.respond(unit == 1 ? "01 03 02 12 34" : "02 03 02 12 34");
    rig_.advance(30ms);
  }
  void ask_in_vain(int times, unsigned unit = 1) {
    for (int at = 0; at < times; ++at) {
      ask(unit);
      rig_.advance(400ms);
    }
  }

  MachineRig rig_{axis_and_lift()};
};

TEST_F(StatusOfAPlant, ShowsWhatThereIs) {
  ask_and_answer();
  const auto shown = report();
  ASSERT_EQ(shown.buses.size(), 1U);
  EXPECT_EQ(shown.buses[0].name, "line-a");
  EXPECT_EQ(shown.buses[0].line, "/dev/ttyS0");
  EXPECT_TRUE(shown.buses[0].is_open);
  EXPECT_EQ(shown.buses[0].counters.responses, 1U);
  EXPECT_EQ(modbus::format_text(shown.buses[0].format), "8E1");
  ASSERT_EQ(shown.devices.size(), 2U);
  EXPECT_EQ(shown.devices[0].name, "axis");
  EXPECT_EQ(shown.devices[0].state, DeviceStatus::State::answering);
  EXPECT_EQ(shown.devices[0].last_answer, Duration{30ms});
  EXPECT_EQ(shown.devices[1].state, DeviceStatus::State::not_asked);
  EXPECT_EQ(shown.devices[1].last_answer, std::nullopt);
  ASSERT_EQ(shown.clients.size(), 1U);
  EXPECT_EQ(shown.clients[0].address, "192.0.2.7");
  EXPECT_EQ(shown.clients[0].listener, "plant");
  EXPECT_EQ(shown.clients[0].requests, 1U);
  EXPECT_EQ(shown.counters.requests, 1U);
  EXPECT_THAT(diagnoses(), IsEmpty());
}

// 8 bytes of 11 bits at 19200 baud take 4.6 ms; the answer comes 30 ms after the request was given.
TEST_F(StatusOfAPlant, SplitsTheTimeOfADevice) {
  for (int at = 0; at < 20; ++at) {
    ask_and_answer();
  }
  const auto shown = report();
  const auto& axis = shown.devices[0];
  EXPECT_LT(*axis.times.queue.lately().percentile(50), 1ms);
  EXPECT_GT(*axis.times.wire.lately().percentile(50), 4ms);
  EXPECT_LT(*axis.times.wire.lately().percentile(50), 6ms);
  EXPECT_GT(*axis.times.device.lately().percentile(50), 25ms);
  EXPECT_LT(*axis.times.device.lately().percentile(99), 33ms);
  EXPECT_EQ(shown.devices[1].times.device.lately().percentile(50), std::nullopt);
}

TEST_F(StatusOfAPlant, ShowsAnAddressWithoutADeviceOnceItWasAsked) {
  ask_in_vain(1, 9);
  const auto shown = report();
  ASSERT_EQ(shown.devices.size(), 3U);
  EXPECT_EQ(shown.devices[2].name, "");
  EXPECT_EQ(shown.devices[2].address, 9U);
  EXPECT_EQ(shown.devices[2].state, DeviceStatus::State::not_answering);
}

TEST_F(StatusOfAPlant, CountsWhatAClientWasRefused) {
  rig_.receive(1, read_request(1, 248));  // no route
  ask_in_vain(1);
  EXPECT_EQ(report().clients[0].requests, 2U);
  EXPECT_EQ(report().clients[0].refused, 2U);
}

TEST_F(StatusOfAPlant, SaysSinceWhenADeviceIsInItsState) {
  EXPECT_EQ(report().devices[0].state_since, std::nullopt);
  ask_and_answer();
  rig_.advance(5s);
  ask_and_answer();
  EXPECT_EQ(report().devices[0].state_since, Duration{5s + 90ms});
  EXPECT_EQ(report().devices[1].state_since, std::nullopt);
  ask();
  rig_.advance(60s);
  EXPECT_EQ(report().devices[0].state, DeviceStatus::State::not_answering);
  EXPECT_LT(*report().devices[0].state_since, 60s);  // its response timeout of 100 ms had to end
  EXPECT_GT(*report().devices[0].state_since, 59s);
  ask_and_answer();
  rig_.lose_line();
  EXPECT_EQ(report().devices[0].state, DeviceStatus::State::line_not_open);
  EXPECT_EQ(report().devices[0].state_since, std::nullopt);
}

TEST_F(StatusOfAPlant, CountsTheExceptionsOfADeviceByTheirCode) {
  for (const auto* answer : {"01 83 02", "01 83 02", "01 83 0B", "01 83 11", "01 83 FF"}) {
    ask();
    rig_.respond(answer);
    rig_.advance(30ms);
  }
  const auto shown = report();
  const auto& axis = shown.devices[0].counters;
  EXPECT_EQ(axis.exceptions, 5U);
  EXPECT_EQ(axis.exceptions_by_code.of(0x01), 0U);
  EXPECT_EQ(axis.exceptions_by_code.of(0x02), 2U);
  EXPECT_EQ(axis.exceptions_by_code.of(0x0B), 1U);
  EXPECT_EQ(axis.exceptions_by_code.others(), 2U);
  EXPECT_EQ(shown.devices[1].counters.exceptions_by_code.of(0x02), 0U);
  rig_.clear_counters();
  EXPECT_EQ(report().devices[0].counters.exceptions_by_code.of(0x02), 0U);
  EXPECT_EQ(report().devices[0].counters.exceptions_by_code.others(), 0U);
}

TEST_F(StatusOfAPlant, CountsAnewWhenCountersAreClearedAndShowsTheSameStates) {
  ask_and_answer();
  ask_in_vain(1, 9);
  rig_.clear_counters();
  const auto shown = report();
  EXPECT_EQ(shown.buses[0].counters.transmissions, 0U);
  EXPECT_EQ(shown.devices[0].counters.responses, 0U);
  EXPECT_EQ(shown.clients[0].requests, 0U);
  EXPECT_EQ(shown.clients[0].refused, 0U);
  EXPECT_EQ(shown.counters.requests, 0U);
  EXPECT_EQ(shown.devices[0].state, DeviceStatus::State::answering);
  EXPECT_EQ(shown.devices[0].last_answer, Duration{460ms});
  ASSERT_EQ(shown.devices.size(), 3U);
  EXPECT_EQ(shown.devices[2].address, 9U);
  EXPECT_EQ(shown.devices[2].state, DeviceStatus::State::not_answering);
}

TEST_F(StatusOfAPlant, SaysNothingOfASingleTimeout) {
  ask_and_answer();
  ask_in_vain(2);
  EXPECT_THAT(diagnoses(), IsEmpty());
}

TEST_F(StatusOfAPlant, NamesADriveThatDoesNotAnswerAnyMore) {
  ask_and_answer();
  ask_in_vain(3);
  EXPECT_THAT(
      diagnoses(),
      ElementsAre("device axis: it does not answer any more | 3 transmissions in a row "
                  "unanswered; the last answer came 1 s ago | its power, its cable; its "
                  "address, baud rate and parity, if it was replaced or reset; a second device at "
                  "address 1; whether it answers later than response_timeout, 100 ms"));
  ask_and_answer();
  EXPECT_THAT(diagnoses(), ElementsAre(testing::StartsWith("listener plant: 60 %")));
}

TEST_F(StatusOfAPlant, NamesADriveThatHasNeverAnsweredBesideOneThatDoes) {
  ask_in_vain(1);
  ask_and_answer(2);
  ask_in_vain(2);
  EXPECT_THAT(
      diagnoses(),
      ElementsAre("device axis: it has never answered | 3 transmissions in a row unanswered; "
                  "others on line-a answer | its power; its address 1; its baud rate and "
                  "parity, here 19200 baud 8E1; its wires"));
}

// Which of these it is cannot be known.
TEST_F(StatusOfAPlant, NamesAllCausesWhereNothingAnswers) {
  ask_in_vain(3);
  ask_in_vain(2, 2);
  EXPECT_THAT(diagnoses(),
              ElementsAre(std::string("bus line-a: nothing answers | 3 transmissions in a row to 1 "
                                      "device unanswered, and nothing else heard | ") +
                          kCausesOfNoAnswer));
  ask_in_vain(1, 2);
  EXPECT_THAT(diagnoses(),
              ElementsAre(std::string("bus line-a: nothing answers | 6 transmissions in a row to 2 "
                                      "devices unanswered, and nothing else heard | ") +
                          kCausesOfNoAnswer));
}

TEST_F(StatusOfAPlant, SaysNothingOfRequestsThatAreStillOnTheirWay) {
  rig_.receive(1, read_request(1, 1));
  rig_.receive(1, read_request(2, 2));
  rig_.receive(1, read_request(3, 3));
  rig_.advance(30ms);
  EXPECT_THAT(diagnoses(), IsEmpty());
}

TEST_F(StatusOfAPlant, NamesALineOnWhichNothingAnswersAnyMore) {
  ask_and_answer();
  ask_and_answer(2);
  ask_in_vain(3);
  ask_in_vain(3, 2);
  EXPECT_THAT(
      diagnoses(),
      ElementsAre("bus line-a: nothing answers any more | 6 transmissions in a row to 2 devices "
                  "unanswered, and nothing else heard | the plug and the cable of the line; "
                  "the power of the drives"));
}

TEST_F(StatusOfAPlant, NamesADriveThatIsSilentAfterBadCrcs) {
  ask_and_answer(2);
  for (int at = 0; at < 5; ++at) {
    ask();
    rig_.line("01 03 02 12 35 B5 33");
    rig_.advance(300ms);
  }
  ask_in_vain(3);
  EXPECT_THAT(diagnoses(), ElementsAre(testing::StartsWith("device axis: it ")));
}

TEST_F(StatusOfAPlant, NamesForeignFramesForAWhile) {
  ask_and_answer();
  rig_.advance(20s);  // what a line had in store when it was opened says nothing
  rig_.line("09 03 00 00 00 01 85 42");
  rig_.advance(5s);
  EXPECT_THAT(diagnoses(),
              ElementsAre("bus line-a: requests of another client are heard | the last one 5 s "
                          "ago, 1 counted | another client on this line (a second gateway, PLC or "
                          "tool)"));
  rig_.clear_counters();
  EXPECT_THAT(diagnoses(),
              ElementsAre("bus line-a: requests of another client are heard | the last one 5 s "
                          "ago | another client on this line (a second gateway, PLC or tool)"));
  rig_.advance(10min);
  EXPECT_THAT(diagnoses(), IsEmpty());
}

TEST_F(StatusOfAPlant, SaysNothingOfALineThatIsBeingOpenedForTheFirstTime) {
  MachineRig starting(axis_and_lift(), false);
  EXPECT_THAT(report::diagnose(starting.harness.gateway().report_status(0s, starting.now())),
              IsEmpty());
}

TEST_F(StatusOfAPlant, NamesALineThatIsNotOpenAndNotItsDrives) {
  ask_and_answer();
  ask_in_vain(3);
  rig_.lose_line();
  EXPECT_THAT(diagnoses(),
              ElementsAre("bus line-a: it is not open: nothing can be sent | /dev/ttyS0 could not "
                          "be opened, or was lost | the adapter and its plug; `device`; who else "
                          "has the port open"));
}

TEST_F(StatusOfAPlant, NamesBadCrcs) {
  for (int at = 0; at < 5; ++at) {
    ask();
    rig_.line("01 03 02 12 35 B5 33");
    rig_.advance(300ms);
  }
  EXPECT_THAT(diagnoses(),
              ElementsAre("device axis: bad CRC in 100 % of its answers | 5 of 5 | termination, "
                          "bias, cable, or two devices at one address"));
}

TEST_F(StatusOfAPlant, NamesALineThatIsAskedForMoreThanItCanCarry) {
  for (int at = 0; at < 120; ++at) {
    for (int more = 0; more < 4; ++more) {
      rig_.receive(1, read_request(1, 1));
    }
    for (int more = 0; more < 3; ++more) {
      rig_.advance(90ms);
      rig_.respond("01 03 02 12 34");
    }
  }
  EXPECT_THAT(diagnoses(), ElementsAre(testing::StartsWith(
                               "bus line-a: it is asked for more than it can carry | busy ")));
}

}  // namespace
}  // namespace mbgate::test

// SPDX-License-Identifier: Apache-2.0
#include "app/journal/event_topic.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "report/text.hpp"

namespace mbgate::app {
namespace {

using bus::LineFault;
using gateway::BusId;
using gateway::ListenerId;
using Notice = bus::DeviceNotice;
using Outcome = gateway::FailsafeOutcome;
using Reason = gateway::RefusalReason;

constexpr BusId kAxes{0};
constexpr ListenerId kPlant{0};

gateway::Settings settings_of_plant() {
  gateway::Settings settings;
  settings.listeners.resize(1);
  settings.listeners[0].name = "plant";
  settings.buses.resize(1);
  settings.buses[0].name = "axes";
  settings.devices.resize(1);
  settings.devices[0].name = "axis-x";
  settings.devices[0].bus = kAxes;
  settings.devices[0].address = 1;
  return settings;
}

routing::ClientAddress address_of_client() {
  return *routing::ClientAddress::parse("192.168.10.5");
}

/// "bus=axes device=axis-x": what is there, without the ID.
std::string subject_of(const Topic& topic) {
  std::string text;
  const auto add = [&](const char* name, const std::string& value) {
    text += value.empty() ? "" : (text.empty() ? "" : " ") + std::string(name) + "=" + value;
  };
  add("bus", topic.bus);
  add("device", topic.device);
  add("address", topic.address);
  add("client", topic.client);
  add("listener", topic.listener);
  add("role", topic.role);
  add("certificate", topic.certificate);
  add("unit", topic.unit);
  add("function", topic.function);
  return text;
}

gateway::Event event_of(Notice notice) { return gateway::DeviceNews{kAxes, notice}; }

gateway::Event event_of(bus::Quality quality, std::optional<std::uint8_t> address) {
  bus::QualityNotice notice{address, {}};
  notice.verdict.quality = quality;
  return gateway::QualityNews{kAxes, notice};
}

gateway::Event event_of(Outcome outcome) {
  return gateway::FailsafeNews{kAxes, 1, gateway::FailsafeReason::gone, outcome};
}

struct Case {
  gateway::Event event;
  MessageId id;
};

std::vector<Case> events_of_lines() {
  using namespace message_id;
  return {
      {gateway::BusOpened{kAxes}, kBusOpened},
      {gateway::BusLost{kAxes}, kBusLost},
      {gateway::AdapterSilent{kAxes, std::chrono::seconds(30), 10}, kAdapterSilent},
      {gateway::LineNeverSilent{kAxes}, kLineNeverSilent},
      {gateway::LineNews{kAxes, LineFault::echo_differed}, kEchoDiffered},
      {gateway::LineNews{kAxes, LineFault::driver_stalled}, kDriverStalled},
      {gateway::LineNews{kAxes, LineFault::framing_lost}, kFramingLost},
      {gateway::LineNews{kAxes, LineFault::answer_cut_off}, kFramingLost},
      {gateway::LineNews{kAxes, LineFault::echo_found}, kEchoFound},
      {gateway::LineNews{kAxes, LineFault::echo_gone}, kEchoGone},
      {gateway::LineNews{kAxes, LineFault::echo_denied}, kEchoDenied},
      {gateway::LineNews{kAxes, LineFault::echo_unproven}, kEchoUnproven},
      {gateway::LineNews{kAxes, LineFault::answered_while_sending}, kAnsweredWhileSending},
      {gateway::LineNews{kAxes, LineFault::unanswered}, kConnectionReplaced},
      {event_of(bus::Quality::bad_crc, std::nullopt), kLineBadCrc},
      {event_of(bus::Quality::good, std::nullopt), kQualityGood},
  };
}

std::vector<Case> events_of_devices() {
  using namespace message_id;
  return {
      {event_of(Notice{Notice::Kind::lost, 1}), kDeviceLost},
      {event_of(Notice{.kind = Notice::Kind::lost, .address = 1, .answered_before = false}),
       kDeviceNeverAnswered},
      {event_of(Notice{Notice::Kind::back, 1}), kDeviceBack},
      {event_of(Notice{Notice::Kind::late, 1}), kDeviceLate},
      {event_of(Notice{Notice::Kind::early, 1}), kDeviceEarly},
      {event_of(Notice{Notice::Kind::foreign, 1}), kForeignFrame},
      {event_of(Notice{Notice::Kind::misfit, 1}), kMisfit},
      {event_of(Notice{Notice::Kind::pauses, 1}), kAnswerPauses},
      {event_of(Notice{.kind = Notice::Kind::foreign, .address = 1, .is_request = true}),
       kForeignRequest},
      {event_of(Notice{Notice::Kind::second_answer, 1}), kSecondAnswer},
      {event_of(Notice{Notice::Kind::stop_unanswered, 1}), kStopUnanswered},
      {event_of(Notice{Notice::Kind::stop_refused, 1}), kStopRefused},
      {event_of(Notice{Notice::Kind::stop_forced, 1}), kStopForced},
      {event_of(bus::Quality::bad_crc, 1), kDeviceBadCrc},
      {event_of(bus::Quality::no_frame, 1), kNoFrame},
      {event_of(bus::Quality::late, 1), kLateAnswers},
      {event_of(bus::Quality::good, 1), kQualityGood},
      {gateway::WriteEndedEarly{kAxes, 1, modbus::Table::holding_registers, 0, 10, 20},
       kWriteEndedEarly},
      {gateway::WordOrderDiffers{kAxes, 1}, kWordOrderDiffers},
      {event_of(Outcome::acknowledged), kFailsafeAcknowledged},
      {event_of(Outcome::waits), kFailsafeWaits},
      {event_of(Outcome::client_back), kFailsafeClientBack},
      {event_of(Outcome::given_up), kFailsafeGivenUp},
      {event_of(Outcome::device_gone), kFailsafeDeviceGone},
  };
}

std::vector<Case> events_of_clients() {
  using namespace message_id;
  const auto client = address_of_client();
  return {
      {gateway::ClientRefused{{kPlant, client}, Reason::not_allowed}, kClientNotAllowed},
      {gateway::ClientRefused{{kPlant, client}, Reason::full}, kClientNoRoom},
      {gateway::ClientRefused{{kPlant, client}, Reason::stopping}, kClientWhileStopping},
      {gateway::ClientRefused{{kPlant, client}, Reason::address_full}, kClientAddressFull},
      {gateway::ClientRefused{{kPlant, client}, Reason::too_often}, kClientTooOften},
      {gateway::ClientOverRate{{kPlant, client}}, kClientOverRate},
      {gateway::ClientDisplaced{{kPlant, client}, Reason::full}, kClientDisplaced},
      {gateway::ClientFramingLost{{kPlant, client}, 0}, kClientFramingLost},
      {gateway::ClientSpeaksRtu{{kPlant, client}}, kClientSpeaksRtu},
      {gateway::ClientFrameTimedOut{{kPlant, client}}, kClientFrameTimedOut},
      {gateway::UnitNotRouted{{kPlant, client}, 9, {}}, kUnitNotRouted},
      {gateway::ClientRefused{{kPlant, client}, Reason::no_rule}, kClientNotRuled},
  };
}

gateway::Asker operator_at_panel() {
  return {kPlant, address_of_client(), {routing::ClientRole::Kind::named, "operator", "panel 3"}};
}

std::vector<Case> events_of_requests() {
  using namespace message_id;
  const gateway::Asked asked{operator_at_panel(), 9, {6, 0, 1, 0, 2}};
  return {
      {gateway::ReadDenied{{asked, "by", 0}}, kRequestDenied},
      {gateway::WriteDenied{{asked, "by", 0}}, kRequestDenied},
      {gateway::StopDenied{{asked, "by", 0}}, kStopDenied},
      {gateway::WriteAccepted{asked}, kWriteAccepted},
      {gateway::BroadcastLeavesOut{asked, true, "axis-x"}, kBroadcastLeavesOut},
      {gateway::CountersCleared{asked}, kCountersCleared},
  };
}

void expect_topics(const std::vector<Case>& cases, const std::string& subject) {
  const auto settings = settings_of_plant();
  for (const auto& [event, id] : cases) {
    const Topic topic = topic_of(event, settings);
    EXPECT_EQ(topic.id.hex, id.hex) << report::to_text(event, settings);
    EXPECT_EQ(subject_of(topic), subject) << report::to_text(event, settings);
  }
}

TEST(EventTopic, OfALineIsItsBus) { expect_topics(events_of_lines(), "bus=axes"); }

TEST(EventTopic, OfADeviceHasItsNameAndWhereItIs) {
  expect_topics(events_of_devices(), "bus=axes device=axis-x address=1");
}

TEST(EventTopic, OfAClientHasItsAddressAndTheListener) {
  expect_topics(events_of_clients(), "client=192.168.10.5 listener=plant");
}

TEST(EventTopic, OfARequestHasWhoMadeItAndForWhat) {
  const std::string who = "client=192.168.10.5 listener=plant role=operator certificate=panel 3";
  expect_topics(events_of_requests(), who + " unit=9 function=6");
  expect_topics({{gateway::ClientLoggedIn{operator_at_panel()}, message_id::kClientLoggedIn}}, who);
}

TEST(EventTopic, OfAnAcceptedWriteHasWhereItGoes) {
  const gateway::Asked asked{{kPlant, address_of_client()}, 9, {6, 0, 1, 0, 2}};
  expect_topics({{gateway::WriteAccepted{asked, true, {{kAxes, 1}}}, message_id::kWriteAccepted}},
                "bus=axes device=axis-x address=1 client=192.168.10.5 listener=plant unit=9 "
                "function=6");
}

TEST(EventTopic, OfADeviceThatAClientHasSetOtherwiseHasBoth) {
  expect_topics({{gateway::Reconfigured{kAxes, 1, address_of_client()}, message_id::kReconfigured}},
                "bus=axes device=axis-x address=1 client=192.168.10.5");
}

TEST(EventTopic, OfAnAddressThatNobodyNamesHasNoDevice) {
  const Topic topic = topic_of(event_of(Notice{Notice::Kind::lost, 7}), settings_of_plant());
  EXPECT_EQ(subject_of(topic), "bus=axes address=7");
}

/// How many of these events reach whoever reads along.
std::size_t written_of(const std::vector<gateway::Event>& events) {
  const int null = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  std::size_t written = 0;
  {
    Log log(false, null);
    log.observe([&](Level, const std::string&) { ++written; });
    for (const gateway::Event& event : events) {
      write_event(log, event, settings_of_plant());
    }
    log.observe({});
    log.flush(std::chrono::seconds(60));
  }
  ::close(null);
  return written;
}

// A loose plug makes some twenty lines a minute.
TEST(WriteEvent, ADeviceThatFlapsHidesNeitherAStopNorAnotherDevice) {
  std::vector<gateway::Event> events(15, event_of(Notice{Notice::Kind::lost, 1}));
  EXPECT_EQ(written_of(events), 10U);
  events.push_back(event_of(Notice{Notice::Kind::stop_unanswered, 1}));
  events.push_back(event_of(Notice{Notice::Kind::stop_refused, 1}));
  events.push_back(event_of(Notice{Notice::Kind::lost, 2}));
  EXPECT_EQ(written_of(events), 13U);
}

TEST(WriteEvent, BroadcastsThatMissADeviceHideNoStopThatDoes) {
  const gateway::Asked asked{operator_at_panel(), 0, {6, 0, 1, 0, 2}};
  std::vector<gateway::Event> events(15, gateway::BroadcastLeavesOut{asked, false, "axis-x"});
  events.push_back(gateway::BroadcastLeavesOut{asked, true, "axis-x"});
  EXPECT_EQ(written_of(events), 11U);
}

/// Of systemd/mbgate.catalog: what the text of each ID takes from the entry, "MBGATE_BUS".
std::map<std::string, std::set<std::string>> fields_of_catalog() {
  std::ifstream file(std::string(MBGATE_SOURCE_DIR) + "/systemd/mbgate.catalog");
  std::map<std::string, std::set<std::string>> fields;
  std::string id;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("-- ")) {
      id = line.substr(3);
      fields[id];
    }
    std::istringstream words(line);
    bool is_field = false;
    for (std::string part; std::getline(words, part, '@'); is_field = !is_field) {
      if (is_field) {
        fields[id].insert(part);
      }
    }
  }
  return fields;
}

// journalctl shows the name of a field that an entry does not have.
TEST(EventTopic, HasWhatTheCatalogPutsIntoItsText) {
  const auto fields = fields_of_catalog();
  const auto settings = settings_of_plant();
  std::size_t used = 0;
  for (const auto& cases :
       {events_of_lines(), events_of_devices(), events_of_clients(), events_of_requests()}) {
    for (const auto& [event, id] : cases) {
      const Topic topic = topic_of(event, settings);
      const auto entry = journal_fields(Level::info, "", topic);
      ASSERT_TRUE(fields.contains(std::string(topic.id.hex)));
      for (const auto& field : fields.at(std::string(topic.id.hex))) {
        ++used;
        EXPECT_TRUE(std::ranges::any_of(
            entry, [&](const std::string& it) { return it.starts_with(field + "="); }))
            << topic.id.hex << " " << field;
      }
    }
  }
  EXPECT_GT(used, 0U);
}

}  // namespace
}  // namespace mbgate::app

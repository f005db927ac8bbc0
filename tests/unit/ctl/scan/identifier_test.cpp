// SPDX-License-Identifier: Apache-2.0
#include "ctl/scan/identifier.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "profile_device.hpp"

namespace mbgate::ctl::identifier_test {
namespace {

using modbus::TableRange;
using testing::ElementsAre;
using testing::IsEmpty;

using Device = std::function<Answer(const TableRange&)>;

struct Outcome {
  Identification found;
  std::vector<TableRange> reads;
};

Outcome identify(const Device& device) {
  Identifier identifier(shipped_catalogue());
  Outcome outcome;
  while (const auto read = identifier.next()) {
    outcome.reads.push_back(*read);
    identifier.take(*read, device(*read));
    if (outcome.reads.size() > 100) {
      ADD_FAILURE() << "it never ends";
      break;
    }
  }
  outcome.found = identifier.result();
  return outcome;
}

Device of(const std::string& profile) {
  return [device = ProfileDevice(profile)](const TableRange& read) { return device.answer(read); };
}

std::vector<std::string> names(const Identification& found) {
  std::vector<std::string> names;
  names.reserve(found.likely.size());
  for (const auto* file : found.likely) {
    names.push_back(file->profile.name);
  }
  return names;
}

TEST(Identifier, NamesEveryShippedProfileFromWhatItsDriveAnswers) {
  for (const auto* file : shipped_files()) {
    const auto& name = file->profile.name;
    if (name == config::kGenericProfile) {
      continue;
    }
    const auto [found, reads] = identify(of(name));
    // Two series whose registers are the same but for what they mean.
    if (name == "moons-ssdc" || name == "moons-stb") {
      EXPECT_THAT(names(found), ElementsAre("moons-ssdc", "moons-stb"));
    } else {
      EXPECT_THAT(names(found), ElementsAre(name));
    }
    EXPECT_EQ(found.fitting, found.judged) << name;
    EXPECT_GE(found.judged, 5U) << name;
    EXPECT_LE(reads.size(), 20U) << name;
  }
}

TEST(Identifier, BeginsWithTheHoldingRegisterThatMostDrivesHave) {
  const Identifier identifier(shipped_catalogue());
  const TableRange first = *identifier.next();
  EXPECT_EQ(first.table, modbus::Table::holding_registers);
  EXPECT_EQ(first.count, 1);
  for (const auto& candidate : shipped_catalogue().candidates()) {
    EXPECT_EQ(candidate.foresees(first), Foreseen::data) << candidate.file().profile.name;
  }
}

TEST(Identifier, NeverAsksTheSameTwice) {
  for (const auto* name : {"autonics-aic", "moons-m3", "rs485-stepper"}) {
    const auto reads = identify(of(name)).reads;
    for (const auto& read : reads) {
      EXPECT_EQ(std::ranges::count(reads, read), 1) << name;
    }
  }
}

TEST(Identifier, TellsTheFunctionsThatGaveData) {
  EXPECT_EQ(identify(of("autonics-aic")).found.functions, std::bitset<5>(0b11110));
  EXPECT_EQ(identify(of("rs485-stepper")).found.functions, std::bitset<5>(0b11000));
  EXPECT_EQ(identify(of("moons-st")).found.functions, std::bitset<5>(0b01000));
}

TEST(Identifier, ReadsWordOrderAndTextsOfTheLikelyProfile) {
  EXPECT_EQ(identify(of("moons-m2")).found.word_order, drive::WordOrder::little);
  EXPECT_EQ(identify(of("moons-st")).found.word_order, std::nullopt);
  EXPECT_EQ(identify(of("rs485-stepper")).found.word_order, drive::WordOrder::little);
  const auto found = identify(of("autonics-aic")).found;
  EXPECT_EQ(found.word_order, drive::WordOrder::big);
  ASSERT_EQ(found.texts.size(), 1U);
  EXPECT_EQ(found.texts.front().name, "model name");
  EXPECT_EQ(found.texts.front().text, "ABABABABAB");
}

TEST(Identifier, StaysWithTheLikelyProfileWhenOneAnswerContradictsIt) {
  const auto m3 = of("moons-m3");
  const auto [found, reads] = identify([&](const TableRange& read) {
    return read.count > 50 ? Answer{AnswerKind::data, 0, std::vector<std::uint16_t>(read.count)}
                           : m3(read);
  });
  EXPECT_THAT(names(found), ElementsAre("moons-m3"));
  EXPECT_EQ(found.fitting + 1, found.judged);
}

TEST(Identifier, TakesSilenceOnUnknownFunctionsForNothing) {
  const auto st = of("moons-st");
  const auto found = identify([&](const TableRange& read) {
                       return read.table == modbus::Table::holding_registers ? st(read) : Answer{};
                     }).found;
  EXPECT_THAT(names(found), ElementsAre("moons-st"));
  EXPECT_EQ(found.fitting, found.judged);
}

TEST(Identifier, FindsNoProfileForADeviceThatAnswersEverything) {
  const auto [found, reads] = identify([](const TableRange& read) {
    return Answer{AnswerKind::data, 0, std::vector<std::uint16_t>(read.count, 1)};
  });
  EXPECT_THAT(names(found), IsEmpty());
  EXPECT_NE(found.nearest, nullptr);
  EXPECT_LT(found.fitting, found.judged);
  EXPECT_LE(reads.size(), 40U);
}

TEST(Identifier, FindsNoProfileForADeviceThatRefusesEverything) {
  const auto found = identify([](const TableRange&) {
                       return Answer{AnswerKind::exception, 0x02};
                     }).found;
  EXPECT_THAT(names(found), IsEmpty());
  EXPECT_EQ(found.functions, std::bitset<5>());
}

TEST(Identifier, WithoutCandidatesAsksForTheFunctionsOnly) {
  const Catalogue nothing({});
  Identifier identifier(nothing);
  int reads = 0;
  for (; identifier.next() && reads < 100; ++reads) {
    const auto read = *identifier.next();
    EXPECT_EQ(read.first, 0);
    identifier.take(read, {AnswerKind::data, 0, {7}});
  }
  EXPECT_EQ(reads, 4);
  EXPECT_EQ(identifier.result().nearest, nullptr);
  EXPECT_THAT(identifier.result().likely, IsEmpty());
}

}  // namespace
}  // namespace mbgate::ctl::identifier_test

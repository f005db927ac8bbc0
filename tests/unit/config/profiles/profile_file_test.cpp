// SPDX-License-Identifier: Apache-2.0
// Profiles out of texts: what they become, and what is said of each file in
// tests/config/profiles-invalid.
#include "config/profiles/profile_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>

namespace mbgate::config::profile_file_test {
namespace {

using namespace std::chrono_literals;
using modbus::Table;
using testing::ElementsAre;
namespace fs = std::filesystem;

const fs::path kFolder = fs::path(MBGATE_SOURCE_DIR) / "tests/config";

std::string text_of(const fs::path& path) {
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

std::vector<fs::path> cases() {
  std::set<fs::path> files;
  for (const auto& entry : fs::directory_iterator(kFolder / "profiles-invalid")) {
    if (entry.path().extension() == ".toml") {
      files.insert(entry.path());
    }
  }
  return {files.begin(), files.end()};
}

std::string case_name(const testing::TestParamInfo<fs::path>& info) {
  std::string name = info.param.stem().string();
  std::ranges::replace(name, '-', '_');
  return name;
}

class InvalidProfile : public testing::TestWithParam<fs::path> {};

TEST_P(InvalidProfile, GivesExactlyTheExpectedText) {
  const auto loaded = load_profile(TextFile{GetParam().filename().string(), text_of(GetParam())});
  auto expected = GetParam();
  EXPECT_EQ(render(loaded.diagnostics), text_of(expected.replace_extension(".expected")));
  EXPECT_FALSE(loaded.diagnostics.empty());
  EXPECT_FALSE(loaded.file);
}

INSTANTIATE_TEST_SUITE_P(Files, InvalidProfile, testing::ValuesIn(cases()), case_name);

TEST(InvalidProfiles, AreAllThere) { EXPECT_GE(cases().size(), 9U); }

ProfileFile file_of(const std::string& name) {
  const auto loaded = load_profile(read_text_file(kFolder / "profiles" / (name + ".toml")));
  EXPECT_EQ(render(loaded.diagnostics), "");
  return loaded.file.value_or(ProfileFile());
}

TEST(ProfileFile, BecomesRulesWithProtocolAddresses) {
  const auto profile = file_of("settable").profile;
  EXPECT_EQ(profile.name, "settable");
  EXPECT_EQ(profile.first_address, 1);
  EXPECT_EQ(profile.last_address, 32);
  EXPECT_EQ(profile.functions.count(), 4U);
  EXPECT_TRUE(profile.functions.test(16));
  EXPECT_TRUE(profile.word_order_settable);
  EXPECT_FALSE(profile.word_order);
  EXPECT_EQ(profile.response_wait, 4ms);
  EXPECT_EQ(profile.limits.read_from(Table::holding_registers), 50);
  EXPECT_EQ(profile.limits.read_from(Table::input_registers), 50);
  EXPECT_EQ(profile.limits.read_from(Table::coils), 2000);
  EXPECT_EQ(profile.limits.write_registers, 40);
  EXPECT_THAT(profile.values.all(),
              ElementsAre(drive::Value{Table::holding_registers, 10, 2, false},
                          drive::Value{Table::holding_registers, 30, 2, true},
                          drive::Value{Table::holding_registers, 50, 4, false},
                          drive::Value{Table::input_registers, 0, 2, false}));
  EXPECT_THAT(profile.groups, ElementsAre(drive::TableRange{Table::holding_registers, 0, 100},
                                          drive::TableRange{Table::holding_registers, 100, 101}));
  EXPECT_THAT(profile.read_only, ElementsAre(drive::TableRange{Table::holding_registers, 10, 2}));
  EXPECT_THAT(profile.write_only, ElementsAre(drive::TableRange{Table::holding_registers, 70, 2}));
  EXPECT_THAT(profile.communication,
              ElementsAre(drive::TableRange{Table::holding_registers, 80, 1}));
}

TEST(ProfileFile, KnowsSpecialWrites) {
  const auto profile = file_of("settable").profile;
  EXPECT_THAT(profile.stops,
              ElementsAre(drive::WriteMatch{Table::holding_registers, 70, 0xFFFF, 0xE1, false, 3},
                          drive::WriteMatch{Table::holding_registers, 71, 1, 0, false}));
  EXPECT_TRUE(profile.acceptances.test(5));
  EXPECT_EQ(profile.acceptances.count(), 1U);
  ASSERT_EQ(profile.slow.size(), 1U);
  EXPECT_EQ(profile.slow[0].range, (drive::TableRange{Table::holding_registers, 90, 1}));
  EXPECT_EQ(profile.slow[0].response_timeout, 3s);
  ASSERT_EQ(profile.unanswered.size(), 1U);
  EXPECT_EQ(profile.unanswered[0].match,
            (drive::WriteMatch{Table::holding_registers, 91, 0xFF00, 0, true}));
  EXPECT_EQ(profile.unanswered[0].after, 2s);
  ASSERT_TRUE(profile.word_order_register);
  EXPECT_EQ(profile.word_order_register->address, 80);
  EXPECT_THAT(profile.word_order_register->big, ElementsAre(5));
  EXPECT_THAT(profile.word_order_register->little, ElementsAre(133));
  ASSERT_TRUE(profile.position_opcodes);
  EXPECT_EQ(profile.position_opcodes->address, 70);
  EXPECT_EQ(profile.position_opcodes->position, 72);
  EXPECT_THAT(profile.position_opcodes->opcodes, ElementsAre(0x98));
}

TEST(ProfileFile, KnowsFixedOrdersAndBroadcasts) {
  const auto fixed = file_of("fixed").profile;
  EXPECT_EQ(fixed.word_order, drive::WordOrder::little);
  EXPECT_FALSE(fixed.word_order_settable);
  EXPECT_TRUE(fixed.input_as_holding);
  EXPECT_EQ(fixed.write_function, 16);
  EXPECT_EQ(fixed.broadcast.form, drive::BroadcastForm{});
  EXPECT_FALSE(fixed.broadcast.allowed);
  EXPECT_EQ(fixed.last_address, 247);
  const auto aic = file_of("aic").profile;
  EXPECT_EQ(aic.broadcast.form, (drive::BroadcastForm{129, 0x80}));
  EXPECT_EQ(aic.broadcast.most_registers, 2);
  ASSERT_TRUE(aic.broadcast.allowed);
  EXPECT_THAT(*aic.broadcast.allowed, ElementsAre(drive::TableRange{Table::coils, 11, 17}));
}

TEST(ProfileFile, KeepsWhatPeopleLookUp) {
  const auto file = file_of("settable");
  EXPECT_EQ(file.description, "A drive for tests");
  EXPECT_EQ(file.path, (kFolder / "profiles/settable.toml").string());
  ASSERT_EQ(file.values.size(), 4U);
  EXPECT_EQ(file.values[1].source.name, "Distance");
  EXPECT_EQ(file.values[1].source.line, 31U);
  EXPECT_EQ(file.values[0].access, ValueAccess::read);
  EXPECT_EQ(file.values[1].access, ValueAccess::read_write);
  EXPECT_EQ(file.strings.at(0).fact, (drive::TableRange{Table::holding_registers, 40, 4}));
  EXPECT_EQ(file.word_order_line, 82U);
  EXPECT_EQ(file.position_opcodes_line, 74U);
  EXPECT_EQ(file.number(Table::holding_registers, 10), "40011");
  EXPECT_EQ(file.number(Table::coils, 10), "0x000A");
}

TEST(ProfileFile, GuardsWritesByTheirValues) {
  const auto loaded = load_profile(TextFile{"guarded.toml", R"(
name = "guarded"
description = "A drive"
manual = "None"
word_order = "big"
response_timeout = "300ms"
values32 = [{ register = 40031 }]
communication = [
  { register = 40081, registers = 2 },
  { register = 40091, value = 0, name = "Restore", line = 9 },
  { register = 40092, mask = 0x0400, value = 0x0400 },
  { register = 40031, registers = 2, mask = 0xFFFFFFFC, not = 8 },
  { table = "coils", register = 7, value = 0xFF00 },
]
[numbering]
holding = 40001
)"});
  EXPECT_EQ(render(loaded.diagnostics), "");
  const auto& profile = loaded.file->profile;
  constexpr auto kHolding = Table::holding_registers;
  EXPECT_EQ(profile.response_timeout, 300ms);
  EXPECT_THAT(profile.communication, ElementsAre(drive::TableRange{kHolding, 80, 2}));
  EXPECT_THAT(profile.guarded,
              ElementsAre(drive::GuardedWrite{{kHolding, 90, 1}, 0xFFFFFFFF, 0},
                          drive::GuardedWrite{{kHolding, 91, 1}, 0x0400, 0x0400},
                          drive::GuardedWrite{{kHolding, 30, 2}, 0xFFFFFFFC, 8, true},
                          drive::GuardedWrite{{Table::coils, 7, 1}, 0xFFFFFFFF, 0xFF00}));
  EXPECT_EQ(loaded.file->guarded.at(0).source.line, 9U);
}

TEST(ProfileFile, ThatIsNotThereIsReported) {
  const auto loaded = load_profile(read_text_file("no-such-folder/x.toml"));
  EXPECT_EQ(render(loaded.diagnostics),
            "no-such-folder/x.toml: error: cannot be read: No such file or directory\n");
  EXPECT_FALSE(loaded.file);
}

}  // namespace
}  // namespace mbgate::config::profile_file_test

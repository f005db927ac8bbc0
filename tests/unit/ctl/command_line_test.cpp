// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "ctl/options/subcommands.hpp"
#include "parsed_line.hpp"

namespace mbgate::ctl {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST(CommandLine, ReadHasSensibleDefaults) {
  const auto read = command<ReadCommand>("read holding 30");
  EXPECT_EQ(read.target.host, "127.0.0.1");
  EXPECT_EQ(read.target.port, 502);
  EXPECT_EQ(read.target.unit, 1);
  EXPECT_EQ(read.target.timeout, std::chrono::seconds(5));
  EXPECT_EQ(read.place.table, Table::holding_registers);
  EXPECT_EQ(read.place.address, 30);
  EXPECT_EQ(read.place.type, ValueType::u16);
  EXPECT_EQ(read.place.order, drive::WordOrder::big);
  EXPECT_EQ(read.count, 1U);
  EXPECT_FALSE(read.quiet);
  EXPECT_FALSE(read.json);
  EXPECT_EQ(read.every, std::nullopt);
  EXPECT_EQ(read.times, std::nullopt);
}

TEST(CommandLine, ReadTakesEveryOption) {
  const auto read = command<ReadCommand>(
      "read input 0x68 --type f32 --order little --count 3 --unit 17 --host ::1 --port 1502 "
      "--timeout 250ms --quiet");
  EXPECT_EQ(read.target.host, "::1");
  EXPECT_EQ(read.target.port, 1502);
  EXPECT_EQ(read.target.unit, 17);
  EXPECT_EQ(read.target.timeout, std::chrono::milliseconds(250));
  EXPECT_EQ(read.place.table, Table::input_registers);
  EXPECT_EQ(read.place.address, 0x68);
  EXPECT_EQ(read.place.type, ValueType::f32);
  EXPECT_EQ(read.place.order, drive::WordOrder::little);
  EXPECT_EQ(read.count, 3U);
  EXPECT_TRUE(read.quiet);
}

TEST(CommandLine, TlsHasAPortOfItsOwnAndNeedsFiles) {
  const std::string files = " --certificate a.crt --key a.key --authorities ca.crt";
  const auto read = command<ReadCommand>("read holding 0 --tls --server-name gw.plant" + files);
  EXPECT_EQ(read.target.port, 802);
  ASSERT_TRUE(read.target.tls.has_value());
  EXPECT_EQ(read.target.tls->certificate, "a.crt");
  EXPECT_EQ(read.target.tls->key, "a.key");
  EXPECT_EQ(read.target.tls->authorities, "ca.crt");
  EXPECT_EQ(read.target.tls->server_name, "gw.plant");
  EXPECT_EQ(command<ReadCommand>("read holding 0 --tls --port 502" + files).target.port, 502);
  EXPECT_FALSE(command<ReadCommand>("read holding 0").target.tls.has_value());
  EXPECT_EQ(complaint("read holding 0 --tls --key a.key"),
            "mbgatectl: --tls needs --certificate, --key and --authorities: client and server "
            "identify each other (mbgate-cert makes such files)");
  EXPECT_EQ(complaint("read holding 0 --key a.key"), "mbgatectl: --key requires --tls");
}

TEST(CommandLine, ReadIsRepeatedOnRequest) {
  const auto read = command<ReadCommand>("read holding 0 --every 500ms --times 3 --json");
  EXPECT_EQ(read.every, std::chrono::milliseconds(500));
  EXPECT_EQ(read.times, 3U);
  EXPECT_TRUE(read.json);
  EXPECT_EQ(command<ReadCommand>("read holding 0 --every 10ms").times, std::nullopt);
  EXPECT_EQ(complaint("read holding 0 --every 9ms"),
            "mbgatectl: \"9ms\" is not a time from 10ms to 1000h, like 500ms or 5s");
  EXPECT_EQ(complaint("read holding 0 --every 1"),
            "mbgatectl: \"1\" is not a time from 10ms to 1000h, like 500ms or 5s");
  EXPECT_EQ(complaint("read holding 0 --times 3"), "mbgatectl: --times requires --every");
  // CLI11 has other words for the range from version to version.
  EXPECT_THAT(
      complaint("read holding 0 --every 1s --times 0"),
      AllOf(StartsWith("mbgatectl: --times: Value 0 not in range "), HasSubstr("1000000000")));
}

TEST(CommandLine, ReplayWantsAFile) {
  const auto replay = command<ReplayCommand>("replay plant.rec");
  EXPECT_EQ(replay.recording, "plant.rec");
  EXPECT_EQ(replay.folder, std::nullopt);
  EXPECT_EQ(command<ReplayCommand>("replay plant.rec --profiles /tmp").folder, "/tmp");
  EXPECT_EQ(complaint("replay"), "mbgatectl: file is required");
}

TEST(CommandLine, EveryTypeHasItsWord) {
  const auto type = [](const std::string& word) {
    return command<ReadCommand>("read holding 0 --type " + word).place.type;
  };
  EXPECT_EQ(type("u16"), ValueType::u16);
  EXPECT_EQ(type("i16"), ValueType::i16);
  EXPECT_EQ(type("u32"), ValueType::u32);
  EXPECT_EQ(type("i32"), ValueType::i32);
  EXPECT_EQ(type("f32"), ValueType::f32);
  EXPECT_EQ(type("u64"), ValueType::u64);
  EXPECT_EQ(type("i64"), ValueType::i64);
  EXPECT_EQ(type("f64"), ValueType::f64);
  EXPECT_EQ(type("string"), ValueType::text);
}

TEST(CommandLine, TablesOfBitsHoldBits) {
  EXPECT_EQ(command<ReadCommand>("read coils 0").place.type, ValueType::bit);
  EXPECT_EQ(command<ReadCommand>("read discrete 0").place.table, Table::discrete_inputs);
  EXPECT_EQ(complaint("read coils 0 --type u16"),
            "mbgatectl: --type is for registers: coils hold bits");
}

TEST(CommandLine, WriteTakesNegativeValuesAndHex) {
  const auto write =
      command<WriteCommand>("write holding 0x1E -5 200000 0xFFFFFFFF --type i32 --unit 3");
  EXPECT_EQ(write.target.unit, 3);
  EXPECT_EQ(write.place.address, 0x1E);
  EXPECT_EQ(write.values, (std::vector<std::uint64_t>{0xFFFFFFFB, 200000, 0xFFFFFFFF}));
  EXPECT_FALSE(write.multiple);
}

TEST(CommandLine, WriteTakes64Bits) {
  const auto write =
      command<WriteCommand>("write holding 0 -9007199254740993 1 --type i64 --order little --json");
  EXPECT_EQ(write.values, (std::vector<std::uint64_t>{0xFFDF'FFFF'FFFF'FFFF, 1}));
  EXPECT_EQ(write.place.order, drive::WordOrder::little);
  EXPECT_TRUE(write.json);
}

TEST(CommandLine, WriteTakesAStringAsItIs) {
  EXPECT_EQ(command<WriteCommand>("write holding 0 AiC --type string").values,
            (std::vector<std::uint64_t>{0x4169, 0x4300}));
  EXPECT_EQ(command<WriteCommand>("write holding 0 [a,b] --type string").values,
            (std::vector<std::uint64_t>{0x5B61, 0x2C62, 0x5D00}));
  EXPECT_EQ(command<WriteCommand>("write holding 0 --type string -- -on").values,
            (std::vector<std::uint64_t>{0x2D6F, 0x6E00}));
  EXPECT_EQ(complaint("write holding 0 two words --type string"),
            "mbgatectl: a string is one value: put a text with spaces in quotes");
}

TEST(CommandLine, AStringHasNoOrder) {
  EXPECT_EQ(command<ReadCommand>("read holding 0 --type string --order big").place.type,
            ValueType::text);
  for (const auto* line : {"read holding 0 --type string --order little",
                           "write holding 0 AiC --type string --order little"}) {
    EXPECT_EQ(complaint(line),
              "mbgatectl: --order is for numbers: the registers of a string are always in the "
              "order of its text");
  }
}

TEST(CommandLine, WriteTakesCoilsAsWords) {
  const auto write = command<WriteCommand>("write coils 11 on off 1 0 --multiple --quiet");
  EXPECT_EQ(write.place.table, Table::coils);
  EXPECT_EQ(write.values, (std::vector<std::uint64_t>{1, 0, 1, 0}));
  EXPECT_TRUE(write.multiple);
  EXPECT_TRUE(write.quiet);
}

TEST(CommandLine, OnlyCoilsAndHoldingRegistersAreWritten) {
  EXPECT_EQ(complaint("write input 0 1"), "mbgatectl: table: input not in {coils,holding}");
  EXPECT_EQ(complaint("write discrete 0 1"), "mbgatectl: table: discrete not in {coils,holding}");
}

TEST(CommandLine, WrongWordsAreNamed) {
  EXPECT_EQ(complaint("read holding 65536"),
            "mbgatectl: \"65536\" is not an address, 0 to 65535 or 0x0 to 0xFFFF");
  EXPECT_EQ(complaint("write holding 0 70000"), "mbgatectl: \"70000\" is outside u16, 0 to 65535");
  EXPECT_EQ(complaint("read holding 0 --timeout 5"),
            "mbgatectl: \"5\" is not a time from 1ms to 1000h, like 500ms or 5s");
  EXPECT_EQ(complaint("read holding 0 --timeout 0s"),
            "mbgatectl: \"0s\" is not a time from 1ms to 1000h, like 500ms or 5s");
  EXPECT_THAT(complaint("read holding 0 --type u8"), StartsWith("mbgatectl: --type: u8 not in "));
  EXPECT_THAT(complaint("read holding 0 --unit 256"), StartsWith("mbgatectl: --unit: "));
  EXPECT_THAT(complaint("read holding 0 --port 0"), StartsWith("mbgatectl: --port: "));
  EXPECT_EQ(complaint("write holding 0"), "mbgatectl: value is required");
  EXPECT_EQ(complaint("read holding"), "mbgatectl: address is required");
  EXPECT_EQ(complaint(""), "mbgatectl: A subcommand is required");
  EXPECT_EQ(complaint("foo --json"), "mbgatectl: there is no subcommand foo");
  EXPECT_THAT(complaint("read holding 0 --count -1"), StartsWith("mbgatectl: --count: "));
  EXPECT_THAT(complaint("read holding 0 --colour red"), HasSubstr("--colour"));
}

TEST(CommandLine, ProfileTakesANameAFolderAndJson) {
  EXPECT_EQ(command<ProfileCommand>("profile").which, "");
  const auto profile =
      command<ProfileCommand>("profile moons-m3 --json --profiles " MBGATE_SOURCE_DIR "/tests");
  EXPECT_EQ(profile.which, "moons-m3");
  EXPECT_EQ(profile.folder, MBGATE_SOURCE_DIR "/tests");
  EXPECT_TRUE(profile.json);
  EXPECT_EQ(complaint("profile --profiles no-such-folder"),
            "mbgatectl: --profiles: Directory does not exist: no-such-folder");
}

TEST(CommandLine, CheckTakesAFileAndAFolder) {
  EXPECT_EQ(command<CheckCommand>("check").config, "/etc/mbgate/mbgate.toml");
  EXPECT_EQ(command<CheckCommand>("check").folder, std::nullopt);
  const auto check = command<CheckCommand>("check new.toml --profiles " MBGATE_SOURCE_DIR "/tests");
  EXPECT_EQ(check.config, "new.toml");
  EXPECT_EQ(check.folder, MBGATE_SOURCE_DIR "/tests");
}

TEST(CommandLine, StatusIsShownOnceUnlessWatched) {
  const auto status = command<StatusCommand>("status --json");
  EXPECT_EQ(status.socket, "/run/mbgate/control");
  EXPECT_TRUE(status.json);
  EXPECT_EQ(status.every, std::nullopt);
  EXPECT_EQ(status.times, std::nullopt);
  EXPECT_FALSE(status.on_terminal);
}

TEST(CommandLine, StatusIsWatchedEverySecondUnlessToldOtherwise) {
  EXPECT_EQ(command<StatusCommand>("status --watch").every, std::chrono::seconds(1));
  const auto watch = command<StatusCommand>("status --watch --every 250ms --times 3 --control c");
  EXPECT_EQ(watch.every, std::chrono::milliseconds(250));
  EXPECT_EQ(watch.times, 3U);
  EXPECT_EQ(watch.socket, "c");
  EXPECT_EQ(complaint("status --watch --every 99ms"),
            "mbgatectl: \"99ms\" is not a time from 100ms to 1000h, like 500ms or 5s");
  EXPECT_EQ(complaint("status --every 1s"), "mbgatectl: --every requires --watch");
  EXPECT_EQ(complaint("status --times 3"), "mbgatectl: --times requires --watch");
}

TEST(CommandLine, CountersAreClearedOverMbgatedsSocket) {
  EXPECT_EQ(command<ClearCountersCommand>("clear-counters").socket, "/run/mbgate/control");
  EXPECT_EQ(command<ClearCountersCommand>("clear-counters --control c").socket, "c");
  EXPECT_THAT(complaint("clear-counters --control tcp://x"),
              StartsWith("mbgatectl: --control: tcp://x: expected a host and a port"));
}

TEST(CommandLine, EventsAreAskedOfMbgatedsSocket) {
  const auto events = command<EventsCommand>("events");
  EXPECT_EQ(events.socket, "/run/mbgate/control");
  EXPECT_FALSE(events.json);
  const auto others = command<EventsCommand>("events --json --control ./control");
  EXPECT_EQ(others.socket, "./control");
  EXPECT_TRUE(others.json);
}

TEST(CommandLine, TraceTakesEveryOption) {
  const auto plain = command<TraceCommand>("trace");
  EXPECT_EQ(plain.socket, "/run/mbgate/control");
  EXPECT_EQ(plain.filter.function, std::nullopt);
  EXPECT_FALSE(plain.filter.only_failed || plain.json || plain.quiet);
  EXPECT_EQ(plain.pcapng, "");
  EXPECT_EQ(plain.times, std::nullopt);
  const auto trace = command<TraceCommand>(
      "trace --bus line-a --device axis-x --client fd00::5 --function 0x10 --failed --json "
      "--pcapng f --quiet --times 3 --control c");
  EXPECT_EQ(trace.filter.bus, "line-a");
  EXPECT_EQ(trace.filter.device, "axis-x");
  EXPECT_EQ(trace.filter.client, "fd00::5");
  EXPECT_EQ(trace.filter.function, 16);
  EXPECT_TRUE(trace.filter.only_failed && trace.json && trace.quiet);
  EXPECT_EQ(trace.pcapng, "f");
  EXPECT_EQ(trace.times, 3U);
  EXPECT_EQ(trace.socket, "c");
}

TEST(CommandLine, TraceSaysWhatAFilterTakes) {
  EXPECT_EQ(complaint("trace --function 300"),
            "mbgatectl: --function \"300\" is not a function code: 1 to 127, like 3 or 0x10");
  EXPECT_EQ(complaint("trace --client plc"),
            "mbgatectl: --client \"plc\" is not an IP address, like 192.168.10.5 or fd00::5");
  EXPECT_EQ(complaint("trace --pcapng - --json"),
            "mbgatectl: --json and --pcapng - both want standard output: name a file for one");
  EXPECT_EQ(complaint("trace --quiet"), "mbgatectl: --quiet requires --pcapng");
}

TEST(CommandLine, HelpAndVersionAreNoErrors) {
  for (const auto* line : {"--help", "read --help", "write --help", "profile --help", "scan --help",
                           "events --help"}) {
    const auto parsed = parse(line);
    ASSERT_TRUE(std::holds_alternative<Notice>(parsed)) << line;
    EXPECT_EQ(std::get<Notice>(parsed).status, 0) << line;
    EXPECT_THAT(std::get<Notice>(parsed).text, HasSubstr("Usage: mbgatectl")) << line;
  }
  const auto version = parse("--version");
  ASSERT_TRUE(std::holds_alternative<Notice>(version));
  EXPECT_EQ(std::get<Notice>(version).status, 0);
  EXPECT_EQ(std::get<Notice>(version).text, "mbgatectl 1.2.3\n");
}

}  // namespace
}  // namespace mbgate::ctl

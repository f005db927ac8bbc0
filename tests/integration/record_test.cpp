// SPDX-License-Identifier: Apache-2.0
// What mbgated --record has written is what the machine does again.
#include <gmock/gmock.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <iterator>

#include "integration/plant.hpp"

namespace mbgate::test {
namespace {

constexpr auto kReadPdu = "03 003C 0002";
constexpr auto kConfiguration =
    "[[listen]]\nname = \"plant\"\nport = 0\nbus = \"a\"\n"
    "[[bus]]\nname = \"a\"\ndevice = \"/dev/no-such-line\"\nbaud = 115200\n";

std::string replay(const TemporaryFolder& folder, const std::string& recording, int status) {
  Process player("mbgatectl", {"replay", recording}, {folder.path(), {}});
  EXPECT_EQ(player.wait_for_exit(), status);
  return player.output();
}

std::string text_of_file(const std::filesystem::path& path) {
  std::ifstream stream(path);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// Reads, writes, and now and then an address where nobody is; half of the connections vanish with
// their requests on the way.
void traffic(Plant& plant) {
  TcpClient steady(plant.port(0));
  TcpClient other(plant.port(1));
  for (unsigned round = 0; round < 150; ++round) {
    steady.send(request(round, 1 + round % 2, round % 5 == 0 ? "06 003C 0001" : kReadPdu));
    other.send(request(round, 1, kReadPdu));
    if (round % 50 == 10) {
      TcpClient leaver(plant.port(0));
      leaver.send(request(1, 9, kReadPdu));
      leaver.send(request(2, 1, "06 003C 1234"));
    }
    EXPECT_TRUE(steady.receive());
    EXPECT_TRUE(other.receive());
  }
  TcpClient closing(plant.port(0));
  closing.send(request(1, 1, kReadPdu));
  closing.half_close();
  EXPECT_TRUE(closing.receive());
  EXPECT_TRUE(closing.is_closed());
}

TEST(Recording, IsReplayedByteForByte) {
  PlantOptions options;
  options.arguments = {"--record", "plant.rec"};
  options.simulator = "reopen_after = \"200ms\"";
  options.response_timeout = "300ms";
  Plant plant(options);
  traffic(plant);
  plant.simulator.signal(SIGUSR2);  // pulls every adapter out for a moment
  plant.gateway.wait_for_line("bus line-0 is lost");
  TcpClient last(plant.port(1));
  last.send(request(1, 9, kReadPdu));  // on the wire, or waiting, when the gateway is asked to stop
  plant.gateway.signal(SIGTERM);
  ASSERT_EQ(plant.gateway.wait_for_exit(), 0) << plant.gateway.output();

  const std::string recorded = text_of_file(plant.folder.path() / "plant.rec");
  EXPECT_NE(recorded.find("< finished\n"), std::string::npos);
  EXPECT_THAT(replay(plant.folder, "plant.rec", 0),
              testing::StartsWith("same actions at every input: "));

  // One digit of the first answer of a device changed: the replay sees it.
  std::string changed = recorded;
  const auto answer = changed.find(" line 0 0103");
  ASSERT_NE(answer, std::string::npos);
  changed.replace(answer, 12, " line 0 0183");
  plant.folder.write("changed.rec", changed);
  EXPECT_THAT(replay(plant.folder, "changed.rec", 1),
              testing::MatchesRegex("changed.rec:[0-9]+: different, after [0-9]+ inputs and [0-9]+ "
                                    "actions that were the same\nthe last input:    .*\n"
                                    "recorded:          .*\nthis version does: .*\n"));

  // An input that is none: its place is named.
  const auto number = 1 + std::ranges::count(recorded.substr(0, recorded.find(" line 0 ")), '\n');
  std::string broken = recorded;
  broken.replace(broken.find(" line 0 "), 8, " wire 0 ");
  plant.folder.write("broken.rec", broken);
  EXPECT_EQ(
      replay(plant.folder, "broken.rec", 78),
      "broken.rec:" + std::to_string(number) + ": error: expected an input, found \"wire\"\n");
}

TEST(Recording, GoesToTheStateDirectory) {
  TemporaryFolder state;
  TemporaryFolder folder;
  const auto config = folder.write("mbgate.toml", kConfiguration);
  const auto prepare = [&] { setenv("STATE_DIRECTORY", state.path().c_str(), 1); };
  Process gateway("mbgated", {"--config", config.string(), "--record", "plant.rec"},
                  {folder.path(), prepare});
  EXPECT_NE(gateway.port_of("plant"), 0);
  gateway.signal(SIGTERM);
  EXPECT_EQ(gateway.wait_for_exit(), 0) << gateway.output();
  EXPECT_THAT(replay(state, "plant.rec", 0), testing::StartsWith("same actions at every input: "));
}

TEST(Recording, ThatCannotBeCreatedStopsTheStart) {
  TemporaryFolder folder;
  const auto config = folder.write("mbgate.toml", kConfiguration);
  Process gateway("mbgated", {"--config", config.string(), "--record", "/missing/plant.rec"},
                  {folder.path(), {}});
  EXPECT_EQ(gateway.wait_for_exit(), 73);
  EXPECT_EQ(gateway.output(),
            "mbgated: cannot create the recording /missing/plant.rec: No such file or directory\n");
}

}  // namespace
}  // namespace mbgate::test

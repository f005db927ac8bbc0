// SPDX-License-Identifier: Apache-2.0
// SIGHUP: the configuration is read again while clients are served.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <iterator>

#include "integration/plant.hpp"

namespace mbgate::test {
namespace {

constexpr auto kReadOfTwo = "03 003C 0002";

std::string content_of(const std::filesystem::path& path) {
  std::ifstream stream(path);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class Reload : public testing::Test {
 protected:
  explicit Reload(const PlantOptions& options = {})
      : plant(options), first(content_of(plant.folder.path() / "mbgate.toml")) {}

  /// Takes `text` for the configuration, and waits until the journal says so.
  void reload(const std::string& text, const std::string& says) {
    plant.folder.write("mbgate.toml", text);
    plant.gateway.signal(SIGHUP);
    plant.gateway.wait_for_line(says);
  }
  /// Function of the answer to a read of drive 1.
  static unsigned ask(TcpClient& client) {
    client.send(request(1, 1, kReadOfTwo));
    const auto answer = client.receive();
    return answer ? (*answer)[7] : 0U;
  }
  /// The configuration with other keys of the first or the second bus.
  [[nodiscard]] std::string with_keys(int bus, const std::string& keys) const {
    std::string text = first;
    const std::string device = "device = \"line-" + std::to_string(bus) + "\"\n";
    text.insert(text.find(device) + device.size(), keys + "\n");
    return text;
  }

  Plant plant;
  std::string first;
};

TEST_F(Reload, SaysWhatHasChangedAndKeepsConnections) {
  TcpClient client(plant.port(0));
  EXPECT_EQ(ask(client), 0x03U);
  reload(with_keys(0, "retries = 3") + "[[listen]]\nname = \"new\"\nport = 0\nbus = \"line-1\"\n",
         "reload: done");
  EXPECT_THAT(plant.gateway.output(),
              testing::AllOf(testing::HasSubstr("notice: reload: listener new added\n"),
                             testing::HasSubstr("notice: reload: bus line-0: retries 1 -> 3\n")));
  EXPECT_EQ(ask(client), 0x03U);
  TcpClient other(plant.gateway.port_of("new"));
  EXPECT_EQ(ask(other), 0x03U);
  reload(first, "reload: listener new removed");
  EXPECT_TRUE(other.is_closed());
  EXPECT_EQ(ask(client), 0x03U);
}

TEST_F(Reload, OfABadFileChangesNothingAndSaysWhy) {
  TcpClient client(plant.port(0));
  reload(with_keys(0, "retries = 300"), "the configuration stays as it is");
  EXPECT_THAT(plant.gateway.output(),
              testing::ContainsRegex("error: .*mbgate.toml:[0-9]+:11: error: retries: expected an "
                                     "integer from 0 to 100, found 300\n"));
  EXPECT_EQ(ask(client), 0x03U);
  reload(first, "reload: nothing has changed");
}

TEST_F(Reload, OpensALineThatLeadsElsewhere) {
  TcpClient client(plant.port(1));
  EXPECT_EQ(ask(client), 0x03U);
  std::string gone = first;
  const std::string device = "device = \"line-1\"";
  gone.replace(gone.find(device), device.size(), "device = \"line-9\"");
  reload(gone, "bus line-1: cannot open line-9");
  EXPECT_EQ(ask(client), 0x83U);
  reload(first, "reload: bus line-1: device");
  while (ask(client) != 0x03U) {
  }
}

class ReloadRecorded : public Reload {
 protected:
  static PlantOptions recorded() {
    PlantOptions options;
    options.arguments = {"--record", "plant.rec"};
    return options;
  }
  ReloadRecorded() : Reload(recorded()) {}
  /// Ends the gateway; the machine does what was recorded again.
  void replay() {
    plant.gateway.signal(SIGTERM);
    ASSERT_EQ(plant.gateway.wait_for_exit(), 0) << plant.gateway.output();
    Process player("mbgatectl", {"replay", "plant.rec"}, {plant.folder.path(), {}});
    EXPECT_EQ(player.wait_for_exit(), 0);
    EXPECT_THAT(player.output(), testing::StartsWith("same actions at every input: "));
  }
};

TEST_F(ReloadRecorded, ReadsTheFilesOfTheFolderToo) {
  const TcpClient started(plant.port(0));
  std::filesystem::create_directory(plant.folder.path() / "conf.d");
  plant.folder.write("conf.d/10-new.toml",
                     "gateway.unit = 7\n"
                     "[[listen]]\nname = \"new\"\nport = 0\nbus = \"line-1\"\n");
  plant.folder.write("conf.d/20-more.toml", "[gateway]\nwake_early = \"50us\"\n");
  reload(first, "reload: listener new added");
  TcpClient other(plant.gateway.port_of("new"));
  EXPECT_EQ(ask(other), 0x03U);
  plant.folder.write("conf.d/20-more.toml", "[gateway]\nunit = 8\n");
  reload(first, "the configuration stays as it is");
  EXPECT_THAT(plant.gateway.output(),
              testing::ContainsRegex("error: .*conf.d/20-more.toml:2:1: error: unit: is already "
                                     "set at .*conf.d/10-new.toml:1:9\n"));
  EXPECT_EQ(ask(other), 0x03U);
  replay();
}

// A hundred reloads, each of which closes and opens the second line, with requests on their way.
TEST_F(ReloadRecorded, LosesNothingOnUnchangedBuses) {
  constexpr unsigned kPipelined = 8;
  TcpClient steady(plant.port(0));
  TcpClient shaken(plant.port(1));
  unsigned answered = 0;
  for (unsigned round = 1; round <= 100; ++round) {
    for (unsigned i = 0; i < kPipelined; ++i) {
      steady.send(request(i, 1 + i % 2, kReadOfTwo));
      shaken.send(request(i, 1 + i % 2, kReadOfTwo));
    }
    const std::string flag = round % 2 == 0 ? "true" : "false";
    reload(with_keys(1, "low_latency = " + flag + "\nqueue = " + std::to_string(3000 + round)),
           "-> " + std::to_string(3000 + round));
    for (unsigned i = 0; i < kPipelined; ++i) {
      const auto answer = steady.receive();
      ASSERT_TRUE(answer);
      EXPECT_EQ((*answer)[7], 0x03) << text_of(*answer);
      ASSERT_TRUE(shaken.receive());
      ++answered;
    }
  }
  EXPECT_EQ(answered, 100U * kPipelined);
  replay();
}

}  // namespace
}  // namespace mbgate::test

// SPDX-License-Identifier: Apache-2.0
// How the daemon starts and goes on where the machine does not give it all that it wants: an
// address that is not there, a port that somebody has, too few descriptors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <deque>
#include <thread>

#include "integration/plant.hpp"

namespace mbgate::test {
namespace {

constexpr std::string_view kReadTwo = "03 003C 0002";

std::string one_drive() {
  return "[[bus]]\nname = \"a\"\nlink = \"a\"\nbaud = 115200\nparity = \"none\"\npaced = false\n"
         "[[device]]\nname = \"drive\"\nbus = \"a\"\naddress = 1\nmodel = \"moons\"\n";
}

std::string listener_text(const std::string& name, const std::string& keys) {
  return "[[listen]]\nname = \"" + name + "\"\nbus = \"a\"\n" + keys + "\n";
}

constexpr const char* kLineA =
    "[[bus]]\nname = \"a\"\ndevice = \"a\"\nbaud = 115200\nparity = \"none\"\n"
    "listen_first = \"0ms\"\nreopen_min = \"10ms\"\nreopen_max = \"50ms\"\n";

bool gets_answer(TcpClient& client, unsigned transaction) {
  client.send(request(transaction, 1, kReadTwo));
  const auto answer = client.receive();
  return answer && answer->size() > 7 && (*answer)[7] == 0x03;
}

// 192.0.2.0/24 is for documentation (RFC 5737): no machine has it.
TEST(Start, ServesThoughTheAddressOfOneListenerIsNotThere) {
  TemporaryFolder folder;
  Process simulator("mbgate-sim", {folder.write("sim.toml", one_drive()).string()},
                    {folder.path(), {}});
  simulator.wait_for_line("ready");
  const auto config =
      folder.write("mbgate.toml", listener_text("lan", "address = \"192.0.2.77\"\nport = 1502") +
                                      listener_text("plant", "port = 0") + kLineA);
  Process gateway("mbgated", {"--config", config.string()}, {folder.path(), {}});
  TcpClient client(gateway.port_of("plant"));
  EXPECT_TRUE(gets_answer(client, 1));
  EXPECT_THAT(
      gateway.output(),
      testing::HasSubstr("listener \"lan\": cannot listen on 192.0.2.77:1502: Cannot assign "
                         "requested address; it is tried again"));
  gateway.signal(SIGTERM);
  EXPECT_EQ(gateway.wait_for_exit(), 0);
}

TEST(Start, ListensOnAnAddressThatIsNotThereIfToldTo) {
  TemporaryFolder folder;
  const auto config = folder.write(
      "mbgate.toml",
      listener_text("lan", "address = \"192.0.2.77\"\nport = 0\nfreebind = true") + kLineA);
  Process gateway("mbgated", {"--config", config.string()}, {folder.path(), {}});
  EXPECT_THAT(gateway.wait_for_line("listening lan "), testing::HasSubstr(" 192.0.2.77:"));
}

TEST(Start, FailsWhereSomebodyElseHasThePort) {
  TemporaryFolder folder;
  const auto first_config = folder.write("first.toml", listener_text("plant", "port = 0") + kLineA);
  Process first("mbgated", {"--config", first_config.string()}, {folder.path(), {}});
  const auto config = folder.write(
      "mbgate.toml",
      listener_text("plant", "port = " + std::to_string(first.port_of("plant"))) + kLineA);
  Process gateway("mbgated", {"--config", config.string()}, {folder.path(), {}});
  EXPECT_EQ(gateway.wait_for_exit(), 1);
  EXPECT_THAT(gateway.output(), testing::HasSubstr("Address already in use"));
}

void limit_descriptors() {
  const rlimit few{64, 160};
  setrlimit(RLIMIT_NOFILE, &few);
}

TEST(Start, SaysThatTheDescriptorsDoNotSuffice) {
  TemporaryFolder folder;
  const auto config = folder.write(
      "mbgate.toml", listener_text("plant", "port = 0\nmax_connections = 400") + kLineA);
  const std::string shortage =
      "warning: max_connections of all listeners together is 400, but the limit of 160 open files "
      "leaves room for 106 clients: lower it, or raise the limit (LimitNOFILE= of the unit) to 454";
  Process check("mbgated", {"--check", "--config", config.string()},
                {folder.path(), limit_descriptors});
  EXPECT_EQ(check.wait_for_exit(), 0);
  EXPECT_THAT(check.output(), testing::HasSubstr(config.string() + ": " + shortage + "\n"));
  Process gateway("mbgated", {"--config", config.string()}, {folder.path(), limit_descriptors});
  gateway.wait_for_line("listening plant");
  EXPECT_THAT(gateway.output(), testing::HasSubstr(shortage));
}

// Clients without end must not keep a line from being opened again.
TEST(Start, KeepsADescriptorForAnAdapterThatIsPluggedInAgain) {
  TemporaryFolder folder;
  const auto simulated = folder.write("sim.toml", one_drive()).string();
  std::optional<Process> simulator(std::in_place, "mbgate-sim", std::vector{simulated},
                                   Process::Options{folder.path(), {}});
  simulator->wait_for_line("ready");
  const auto config = folder.write(
      "mbgate.toml", listener_text("plant", "port = 0\nmax_connections = 400") + kLineA);
  Process gateway("mbgated", {"--config", config.string()}, {folder.path(), limit_descriptors});
  const auto port = gateway.port_of("plant");
  TcpClient client(port);
  ASSERT_TRUE(gets_answer(client, 1));
  std::deque<TcpClient> crowd;
  for (int i = 0; i < 200; ++i) {
    crowd.emplace_back(port);
  }
  gateway.wait_for_line("cannot accept clients");
  simulator.reset();
  gateway.wait_for_line("bus a is lost");
  simulator.emplace("mbgate-sim", std::vector{simulated}, Process::Options{folder.path(), {}});
  simulator->wait_for_line("ready");
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  unsigned transaction = 2;
  bool answered = false;
  while (!answered && std::chrono::steady_clock::now() < end) {
    answered = gets_answer(client, transaction++);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_TRUE(answered) << gateway.output();
}

}  // namespace
}  // namespace mbgate::test

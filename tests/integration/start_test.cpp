// SPDX-License-Identifier: Apache-2.0
// How the daemon starts: what it takes for its configuration, what waited for it, and how it goes
// on where the machine does not give it all that it wants: an address that is not there, a port
// that somebody has, too few descriptors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

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
    "listen_first = \"0ms\"\nresponse_timeout = \"20s\"\nreopen_min = \"10ms\"\nreopen_max = "
    "\"50ms\"\n";

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
  const auto config = folder.write(
      "mbgate.toml",
      listener_text("lan", "address = \"192.0.2.77\"\nallow = [\"::/0\"]\nport = 1502") +
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
      listener_text("lan",
                    "address = \"192.0.2.77\"\nallow = [\"::/0\"]\nport = 0\nfreebind = true") +
          kLineA);
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
      "warning: max_connections of all listeners together is 400, the HTTP interface may need 129 "
      "more, but the limit of 160 open files leaves room for 105 clients: lower max_connections or "
      "[http] max_streams, or raise the limit (LimitNOFILE= of the unit) to 584";
  Process check("mbgated", {"--check", "--config", config.string()},
                {folder.path(), limit_descriptors});
  EXPECT_EQ(check.wait_for_exit(), 0);
  EXPECT_THAT(check.output(), testing::HasSubstr(config.string() + ": " + shortage + "\n"));
  Process gateway("mbgated", {"--config", config.string()}, {folder.path(), limit_descriptors});
  gateway.wait_for_line("listening plant");
  EXPECT_THAT(gateway.output(), testing::HasSubstr(shortage));
  folder.write("mbgate.toml", listener_text("plant", "port = 0\nmax_connections = 401") + kLineA);
  gateway.signal(SIGHUP);
  gateway.wait_for_line("warning: max_connections of all listeners together is 401");
}

// Clients without end must not keep a line from being opened again.
TEST(Start, KeepsADescriptorForAnAdapterThatIsPluggedInAgain) {
  TemporaryFolder folder;
  const auto simulated = folder.write("sim.toml", one_drive()).string();
  std::optional<Process> simulator(std::in_place, "mbgate-sim", std::vector{simulated},
                                   Process::Options{folder.path(), {}});
  simulator->wait_for_line("ready");
  const auto config =
      folder.write("mbgate.toml",
                   listener_text("plant",
                                 "port = 0\nmax_connections = 400\n"
                                 "max_connections_per_address = 400\nmax_connects_per_second = 0") +
                       kLineA);
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
  const auto end = std::chrono::steady_clock::now() + kPatience;
  unsigned transaction = 2;
  bool answered = false;
  while (!answered && std::chrono::steady_clock::now() < end) {
    answered = gets_answer(client, transaction++);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_TRUE(answered) << gateway.output();
}

// A socket of systemd's that a client has used before the gateway runs: LISTEN_FDS as in
// sd_listen_fds(3).
TEST(Mbgated, RefusesWritesThatWaitedBeforeItStarted) {
  const int listening = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ASSERT_EQ(bind(listening, reinterpret_cast<const sockaddr*>(&address), size), 0);
  ASSERT_EQ(listen(listening, 8), 0);
  ASSERT_EQ(getsockname(listening, reinterpret_cast<sockaddr*>(&address), &size), 0);
  TcpClient client(ntohs(address.sin_port));
  ByteString waiting = request(1, 1, "06 003C 0001");
  const ByteString read = request(2, 1, kReadTwo);
  waiting.insert(waiting.end(), read.begin(), read.end());
  ASSERT_TRUE(client.send(waiting));

  TemporaryFolder folder;
  const auto simulated = folder.write(
      "sim.toml",
      "[[bus]]\nname = \"a\"\nlink = \"a\"\nbaud = 115200\nparity = \"none\"\npaced = false\n"
      "[[device]]\nname = \"drive\"\nbus = \"a\"\naddress = 1\nmodel = \"moons\"\n");
  Process simulator("mbgate-sim", {simulated.string()}, {folder.path(), {}});
  simulator.wait_for_line("ready");
  const auto config =
      folder.write("mbgate.toml",
                   "[[listen]]\nname = \"plant\"\nport = 0\nbus = \"a\"\n"
                   "[[bus]]\nname = \"a\"\ndevice = \"a\"\nbaud = 115200\nparity = \"none\"\n"
                   "response_timeout = \"20s\"\n");
  Process gateway("mbgated", {"--config", config.string()},
                  {folder.path(), [listening] {
                     dup2(listening, 3);
                     setenv("LISTEN_FDS", "1", 1);
                     setenv("LISTEN_FDNAMES", "plant", 1);
                     setenv("LISTEN_PID", std::to_string(getpid()).c_str(), 1);
                   }});
  EXPECT_EQ(text_of(client.receive().value_or(ByteString{})), "00 01 00 00 00 03 01 86 06");
  EXPECT_EQ(text_of(client.receive().value_or(ByteString{})),
            "00 02 00 00 00 07 01 03 04 00 00 00 00");
  ASSERT_TRUE(client.send(request(3, 1, "06 003C 0001")));
  EXPECT_EQ(text_of(client.receive().value_or(ByteString{})),
            "00 03 00 00 00 06 01 06 00 3C 00 01");
  close(listening);
}

TEST(Mbgated, RefusesABadConfigurationWithAllItsErrors) {
  TemporaryFolder folder;
  const auto config = folder.write("bad.toml",
                                   "[[listen]]\nname = \"plant\"\nprot = 502\nport = \"x\"\n"
                                   "[[bus]]\nname = \"a\"\ndevice = \"/dev/ttyS0\"\nbaud = 0\n");
  for (const bool check : {true, false}) {
    std::vector<std::string> arguments{"--config", config.string()};
    if (check) {
      arguments.emplace_back("--check");
    }
    Process gateway("mbgated", arguments, {folder.path(), {}});
    EXPECT_EQ(gateway.wait_for_exit(), 78);
    EXPECT_THAT(gateway.output(), testing::HasSubstr("bad.toml:3:1: error: "));
    EXPECT_THAT(gateway.output(), testing::HasSubstr("bad.toml:4:8: error: "));
    EXPECT_THAT(gateway.output(), testing::HasSubstr("bad.toml:8:8: error: "));
  }
}

TEST(Mbgated, ChecksTheShippedConfiguration) {
  TemporaryFolder folder;
  Process gateway("mbgated", {"--check", "--config", MBGATE_SOURCE_DIR "/conf/etc/mbgate.toml"},
                  {folder.path(), {}});
  EXPECT_EQ(gateway.wait_for_exit(), 0) << gateway.output();
  EXPECT_THAT(gateway.output(), testing::HasSubstr("warning: no [[bus]] is configured: "));
}

}  // namespace
}  // namespace mbgate::test

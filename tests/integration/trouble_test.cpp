// SPDX-License-Identifier: Apache-2.0
// What goes wrong in a plant: vanished adapters, dead drives, hostile clients, the end of the
// process.
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <ostream>
#include <thread>

#include "integration/plant.hpp"

namespace mbgate::test {
namespace {

constexpr auto kReadPdu = "03 003C 0002";

unsigned exception_of(const std::optional<ByteString>& answer) {
  return answer && answer->size() == 9 && (answer->at(7) & 0x80U) != 0 ? answer->at(8) : 0U;
}

// Asks until the answer is no exception any more: service has resumed. Bounded by tries.
bool serves_again(TcpClient& client) {
  for (unsigned attempt = 0; attempt < 400; ++attempt) {
    client.send(request(attempt, 1, kReadPdu));
    const auto answer = client.receive();
    if (!answer) {
      return false;
    }
    if (exception_of(answer) == 0) {
      return true;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
  }
  return false;
}

TEST(Plant, SurvivesAnAdapterThatVanishesAndReturns) {
  PlantOptions options;
  options.simulator = "reopen_after = \"500ms\"";
  Plant plant(options);
  TcpClient client(plant.port(0));
  ASSERT_TRUE(serves_again(client));
  plant.simulator.signal(SIGUSR2);  // pulls every adapter out for half a second
  plant.gateway.wait_for_line("bus line-0 is lost");
  client.send(request(1, 1, kReadPdu));
  const unsigned code = exception_of(client.receive());
  EXPECT_TRUE(code == 0x0A || code == 0x0B) << code;
  EXPECT_TRUE(serves_again(client));
}

TEST(Plant, OutlivesSignalsThatMeanNothingToIt) {
  Plant plant(PlantOptions{});
  TcpClient client(plant.port(0));
  ASSERT_TRUE(serves_again(client));
  for (const int number : {SIGUSR1, SIGUSR2, SIGHUP, SIGPIPE}) {
    plant.gateway.signal(number);
    client.send(request(1, 1, kReadPdu));
    EXPECT_TRUE(client.receive()) << "signal " << number;
  }
}

TEST(Plant, StartsWithoutItsPortAndServesOnceItIsThere) {
  TemporaryFolder folder;
  const auto config =
      folder.write("mbgate.toml",
                   "[[listen]]\nname = \"plant\"\nport = 0\nbus = \"line-0\"\n"
                   "[[bus]]\nname = \"line-0\"\ndevice = \"line-0\"\nbaud = 115200\n"
                   "parity = \"none\"\nlisten_first = \"0ms\"\n");
  Process gateway("mbgated", {"--config", config.string()}, {folder.path(), {}});
  TcpClient client(gateway.port_of("plant"));
  gateway.wait_for_line("line-0");  // it says what is missing
  client.send(request(1, 1, kReadPdu));
  EXPECT_EQ(exception_of(client.receive()), 0x0AU);
  const auto simulated = folder.write(
      "sim.toml",
      "[[bus]]\nname = \"line-0\"\nlink = \"line-0\"\nbaud = 115200\nparity = \"none\"\npaced = "
      "false\n"
      "[[device]]\nname = \"drive\"\nbus = \"line-0\"\naddress = 1\nmodel = \"moons\"\n");
  Process simulator("mbgate-sim", {simulated.string()}, {folder.path(), {}});
  simulator.wait_for_line("ready");
  EXPECT_TRUE(serves_again(client));
}

TEST(Plant, ASilentDriveGives0BAndDisturbsNobodyElse) {
  Plant plant;
  TcpClient client(plant.port(0));
  TcpClient other(plant.port(1));
  client.send(request(1, 9, kReadPdu));  // nobody has address 9
  for (unsigned round = 0; round < 20; ++round) {
    other.send(request(round, 1, kReadPdu));
    EXPECT_EQ(exception_of(other.receive(200)), 0U);
  }
  EXPECT_EQ(exception_of(client.receive()), 0x0BU);
}

struct Hostile {
  const char* what;
  const char* bytes;
  bool closes;
  const char* answer;  // "" for none
};

void PrintTo(const Hostile& hostile, std::ostream* stream) { *stream << hostile.what; }

class HostileInput : public testing::TestWithParam<Hostile> {};

TEST_P(HostileInput, GetsWhatTheContractSaysAndDisturbsNobody) {
  static Plant plant;
  TcpClient hostile(plant.port(0));
  TcpClient good(plant.port(0));
  const Hostile& given = GetParam();
  hostile.send(bytes_of(given.bytes));
  if (*given.answer != '\0') {
    const auto answer = hostile.receive();
    ASSERT_TRUE(answer);
    EXPECT_EQ(text_of(*answer), given.answer);
  }
  good.send(request(7, 1, kReadPdu));
  EXPECT_EQ(exception_of(good.receive()), 0U);
  if (given.closes) {
    EXPECT_TRUE(hostile.is_closed());
  } else {
    hostile.send(request(8, 0xF9, kReadPdu));  // no such path; but still understood
    const auto answer = hostile.receive();
    ASSERT_TRUE(answer);
    EXPECT_EQ(text_of(*answer), "00 08 00 00 00 03 F9 83 0A");
  }
}

INSTANTIATE_TEST_SUITE_P(
    Plant, HostileInput,
    testing::Values(
        Hostile{"protocol identifier", "0001 0001 0006 01 03 003C 0002", false, ""},
        Hostile{"length 0", "0001 0000 0000 01 03", true, ""},
        Hostile{"length 1", "0001 0000 0001 01", true, ""},
        Hostile{"length 255", "0001 0000 00FF 01 03", true, ""},
        Hostile{"length 65535", "0001 0000 FFFF 01 03", true, ""},
        Hostile{"function 0", "0001 0000 0002 01 00", false, "00 01 00 00 00 03 01 80 01"},
        Hostile{"function 255", "0001 0000 0002 01 FF", false, "00 01 00 00 00 03 01 FF 01"},
        Hostile{"cut PDU", "0001 0000 0004 01 03 003C", false, "00 01 00 00 00 03 01 83 03"},
        Hostile{"byte count lies", "0001 0000 0009 01 10 003C 0001 04 0001", false,
                "00 01 00 00 00 03 01 90 03"},
        Hostile{"RTU frame", "01 03 00 1E 00 02 A4 0D", false, ""}),
    [](const testing::TestParamInfo<Hostile>& hostile) {
      std::string name = hostile.param.what;
      std::erase_if(name, [](char character) {
        return std::isalnum(static_cast<unsigned char>(character)) == 0;
      });
      return name;
    });

TEST(Plant, AClientThatNeverReadsCostsNoMemoryAndNobodyElseAnything) {
  Plant plant;
  TcpClient warm(plant.port(0));
  warm.send(request(1, 1, kReadPdu));
  ASSERT_TRUE(warm.receive());
  const std::size_t before = resident_memory(plant.gateway.pid());
  TcpClient stuck(plant.port(0));
  const int small = 4096;
  setsockopt(stuck.descriptor(), SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
  const ByteString one = request(1, 0xF9, kReadPdu);  // answered at once by the gateway
  ByteString many;
  while (many.size() < 64'000) {
    many.insert(many.end(), one.begin(), one.end());
  }
  std::size_t sent = 0;
  for (int idle = 0; idle < 20 && sent < 50'000'000;) {
    const ssize_t count =
        ::send(stuck.descriptor(), many.data(), many.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (count > 0) {
      sent += static_cast<std::size_t>(count);
      idle = 0;
      continue;
    }
    ++idle;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_LT(sent, 50'000'000U) << "the gateway read on and on";
  warm.send(request(2, 1, kReadPdu));
  EXPECT_EQ(exception_of(warm.receive(1000)), 0U);
  EXPECT_LT(resident_memory(plant.gateway.pid()), before + 32'000'000U);
}

// The read keeps the bus busy for long enough that the gateway sees the client leave meanwhile,
// even where the machine is busy too.
TEST(Plant, ADepartedClientsWaitingWriteIsNeverOnTheWire) {
  PlantOptions options;
  options.response_timeout = "1500ms";
  Plant plant(options);
  TcpClient witness(plant.port(0));
  witness.send(request(1, 1, "06 003C 0000"));
  ASSERT_TRUE(witness.receive());
  {
    TcpClient leaver(plant.port(0));
    leaver.send(request(1, 9, kReadPdu));  // nobody there
    leaver.send(request(3, 0xF9, kReadPdu));
    ASSERT_TRUE(leaver.receive());  // the gateway's own: the read before it is on the wire
    leaver.send(request(2, 1, "06 003C 1234"));
  }
  witness.send(request(2, 1, "03 003C 0001"));
  EXPECT_EQ(text_of(witness.receive().value_or(ByteString{})), "00 02 00 00 00 05 01 03 02 00 00");
}

TEST(Plant, StopsInOrderAndInTime) {
  Plant plant;
  TcpClient client(plant.port(0));
  client.send(request(4, 1, kReadPdu));
  ASSERT_TRUE(client.receive());         // the line is open
  client.send(request(1, 9, kReadPdu));  // on the wire, unanswered
  client.send(request(2, 1, kReadPdu));  // waiting
  client.send(request(3, 0xF9, kReadPdu));
  ASSERT_TRUE(client.receive());  // the third one's answer: all three have been read
  plant.gateway.signal(SIGTERM);
  EXPECT_EQ(exception_of(client.receive()), 0x06U);
  EXPECT_EQ(exception_of(client.receive()), 0x0BU);
  EXPECT_TRUE(client.is_closed());
  EXPECT_EQ(plant.gateway.wait_for_exit(std::chrono::seconds(3)), 0);
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
  const ByteString read = request(2, 1, kReadPdu);
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
                   "[[bus]]\nname = \"a\"\ndevice = \"a\"\nbaud = 115200\nparity = \"none\"\n");
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
  Process gateway("mbgated", {"--check", "--config", MBGATE_SOURCE_DIR "/conf/mbgate.toml"},
                  {folder.path(), {}});
  EXPECT_EQ(gateway.wait_for_exit(), 0) << gateway.output();
}

}  // namespace
}  // namespace mbgate::test

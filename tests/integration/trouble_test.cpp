// SPDX-License-Identifier: Apache-2.0
// What goes wrong in a plant: vanished adapters, dead drives, hostile clients, the end of the
// process.
#include <gmock/gmock.h>
#include <sys/socket.h>

#include <csignal>
#include <ostream>
#include <thread>

#include "integration/plant.hpp"

namespace mbgate::test::trouble_test {
namespace {

constexpr auto kReadPdu = "03 003C 0002";

unsigned exception_of(const std::optional<ByteString>& answer) {
  return answer && answer->size() == 9 && (answer->at(7) & 0x80U) != 0 ? answer->at(8) : 0U;
}

// Asks until the answer is no exception any more: service has resumed.
bool serves_again(TcpClient& client) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  for (unsigned attempt = 0; std::chrono::steady_clock::now() < end; ++attempt) {
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
  client.send(request(1, 9, kReadPdu));  // nobody is there: it lies on the wire
  client.send(request(2, 1, kReadPdu));  // and this one waits
  client.send(request(3, 0xF9, kReadPdu));
  ASSERT_TRUE(client.receive());    // the third one's answer: all three have been read
  plant.simulator.signal(SIGUSR2);  // pulls every adapter out for half a second
  EXPECT_EQ(exception_of(client.receive()), 0x0BU);
  EXPECT_EQ(exception_of(client.receive()), 0x0AU);
  EXPECT_TRUE(serves_again(client));
}

TEST(Plant, OutlivesSignalsThatMeanNothingToIt) {
  Plant plant(PlantOptions{});
  TcpClient client(plant.port(0));
  ASSERT_TRUE(serves_again(client));
  for (const int number : {SIGUSR1, SIGUSR2, SIGPIPE}) {
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
  {
    Plant impatient({.response_timeout = "300ms"});
    TcpClient client(impatient.port(0));
    client.send(request(1, 9, kReadPdu));  // nobody has address 9
    EXPECT_EQ(exception_of(client.receive()), 0x0BU);
  }
  Plant patient({.response_timeout = "10m"});
  TcpClient client(patient.port(0));
  TcpClient other(patient.port(1));
  client.send(request(1, 9, kReadPdu));
  for (unsigned round = 0; round < 20; ++round) {
    other.send(request(round, 1, kReadPdu));
    const auto answer = other.receive();
    ASSERT_TRUE(answer);
    EXPECT_EQ(exception_of(answer), 0U);
  }
  EXPECT_FALSE(client.receive(0));
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
  const auto answer = warm.receive();
  ASSERT_TRUE(answer);
  EXPECT_EQ(exception_of(answer), 0U);
  EXPECT_LT(resident_memory(plant.gateway.pid()), before + 32'000'000U);
}

unsigned clients_of(TcpClient& client) {
  client.send(request(0x255, 0xFF, "04 0003 0001"));  // the gateway itself
  const auto answer = client.receive();
  return answer && answer->size() == 11 ? unsigned{answer->at(9)} << 8U | answer->at(10) : 0U;
}

// Has the client gone while the bus was busy with the read of a silent drive? Only then is it
// certain that its write had not been transmitted before; a busy machine may be later.
bool leaves_in_time(Plant& plant, TcpClient& witness) {
  TcpClient blocking(plant.port(0));
  blocking.send(request(1, 9, kReadPdu));  // nobody there
  blocking.send(request(2, 0xF9, kReadPdu));
  EXPECT_TRUE(blocking.receive());  // the gateway's own: the read before it is on the wire
  const unsigned before = clients_of(witness);
  {
    TcpClient leaver(plant.port(0));
    leaver.send(request(1, 1, "06 003C 1234"));
    leaver.send(request(2, 0xF9, kReadPdu));
    EXPECT_TRUE(leaver.receive());
  }
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (clients_of(witness) > before && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const bool was_busy = !blocking.receive(0);
  EXPECT_TRUE(!was_busy || blocking.receive());
  return was_busy;
}

TEST(Plant, ADepartedClientsWaitingWriteIsNeverOnTheWire) {
  for (const char* response_timeout : {"300ms", "3s", "20s"}) {
    Plant plant({.response_timeout = response_timeout});
    TcpClient witness(plant.port(0));
    ASSERT_TRUE(serves_again(witness));
    if (leaves_in_time(plant, witness)) {
      witness.send(request(2, 1, "03 003C 0001"));
      EXPECT_EQ(text_of(witness.receive().value_or(ByteString{})),
                "00 02 00 00 00 05 01 03 02 00 00");
      return;
    }
  }
  ADD_FAILURE() << "the gateway did not see within 40 s that a client had gone";
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
  EXPECT_EQ(plant.gateway.wait_for_exit(), 0);
}

}  // namespace
}  // namespace mbgate::test::trouble_test

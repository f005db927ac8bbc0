// SPDX-License-Identifier: Apache-2.0
// Buses that are TCP connections: mbgated in front of a Modbus TCP server by libmodbus, and in
// front of another mbgated.
#include <gmock/gmock.h>

#include <set>
#include <thread>

#include "integration/near_gateway.hpp"

namespace mbgate::test {
namespace {

/// What does not come within it is seen by chance only; what must not come never comes.
constexpr int kNoMoreComeMs = 250;

TEST(Downstream, CarriesReadsAndWrites) {
  FarServer far;
  NearGateway near(far.port(), kPatient);
  TcpClient client = near.client();
  EXPECT_EQ(ask(client, "03 000A 0002"), "03 04 03 F2 03 F3");
  EXPECT_EQ(ask(client, "04 000A 0001"), "04 02 07 DA");
  EXPECT_EQ(ask(client, "06 0014 1234"), "06 00 14 12 34");
  EXPECT_EQ(ask(client, "10 0015 0002 04 0007 0008"), "10 00 15 00 02");
  EXPECT_EQ(ask(client, "03 0014 0003"), "03 06 12 34 00 07 00 08");
  EXPECT_EQ(ask(client, "05 0007 FF00"), "05 00 07 FF 00");
  EXPECT_EQ(ask(client, "01 0006 0003"), "01 01 02");
  EXPECT_EQ(ask(client, "03 0000 007D").size(), 3U * (2 + 2 * 125) - 1);
}

TEST(Downstream, ReachesADeviceWithoutAnAddressAsUnit255) {
  FarServer far;
  NearGateway near(far.port(), kPatient);
  TcpClient client = near.routed_client();
  EXPECT_EQ(ask(client, kRead, 5), "03 02 03 F2");
  EXPECT_EQ(far.arrivals().back().unit, 255U);
}

TEST(Downstream, HasTransactionIdentifiersOfItsOwn) {
  FarServer far;
  NearGateway near(far.port(), kPatientWithFour);
  const std::size_t before = far.arrivals().size();
  far.gather(4, -1);
  std::vector<TcpClient> clients;
  for (unsigned i = 0; i < 4; ++i) {
    clients.push_back(near.client());
    clients[i].send(request(0x0707, kUnit, "03 00" + text_of({std::uint8_t(0x20 + i)}) + " 0001"));
  }
  // The far end answers the last one first.
  for (unsigned i = 0; i < 4; ++i) {
    const auto answer = clients[i].receive();
    ASSERT_TRUE(answer);
    // Register 0x20 holds 1032, which is 0408 in hexadecimal.
    EXPECT_EQ(text_of(*answer), std::string("07 07 00 00 00 05 01 03 02 04 0") + "89AB"[i]);
  }
  std::set<unsigned> identifiers;
  const auto arrivals = far.arrivals();
  for (std::size_t i = before; i < arrivals.size(); ++i) {
    identifiers.insert(arrivals[i].transaction);
  }
  EXPECT_EQ(identifiers.size(), 4U);
  EXPECT_EQ(far.most_waiting(), 4U);
}

TEST(Downstream, HasOneRequestOnItsWayUnlessToldOtherwise) {
  FarServer far;
  NearGateway near(far.port(), kPatient);
  far.gather(4, kNoMoreComeMs);
  std::vector<TcpClient> clients;
  for (unsigned i = 0; i < 3; ++i) {
    clients.push_back(near.client());
    clients[i].send(request(i, kUnit, kRead));
  }
  for (auto& client : clients) {
    EXPECT_EQ(pdu_of(client.receive()), "03 02 03 F2");
  }
  EXPECT_EQ(far.most_waiting(), 1U);
}

TEST(Downstream, LeavesADeviceToItsWrite) {
  FarServer far;
  NearGateway near(far.port(), kPatientWithFour);
  far.gather(4, kNoMoreComeMs);
  TcpClient writer = near.client();
  TcpClient reader = near.client();
  writer.send(request(1, kUnit, "06 0014 0001"));
  reader.send(request(2, kUnit, kRead));
  EXPECT_EQ(pdu_of(writer.receive()), "06 00 14 00 01");
  EXPECT_EQ(pdu_of(reader.receive()), "03 02 03 F2");
  EXPECT_FALSE(far.had_company());
}

TEST(Downstream, ServesEightClientsAtOnce) {
  FarServer far;
  NearGateway near(far.port(), kPatientWithFour);
  std::vector<std::thread> threads;
  threads.reserve(8);
  std::atomic<int> wrong{0};
  for (unsigned number = 0; number < 8; ++number) {
    threads.emplace_back([&near, number, &wrong] {
      TcpClient client = near.client();
      for (unsigned round = 0; round < 100; ++round) {
        const auto address = static_cast<std::uint8_t>((round * 7 + number * 13) % 200);
        const unsigned value = 1000U + address;
        const ByteString expected{3, 2, static_cast<std::uint8_t>(value >> 8U),
                                  static_cast<std::uint8_t>(value & 0xFFU)};
        wrong += ask(client, "03 00" + text_of({address}) + " 0001") == text_of(expected) ? 0 : 1;
      }
    });
  }
  for (auto& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(wrong, 0);
}

TEST(Downstream, GivesUpWithoutRepeatingAWrite) {
  FarServer far;
  NearGateway near(far.port(), kImpatient);
  TcpClient client = near.client();
  EXPECT_EQ(ask(client, "06 0118 0001"), "86 0B");
  EXPECT_TRUE(serves(client));
  const auto arrivals = far.arrivals();
  EXPECT_EQ(std::ranges::count(arrivals, unsigned{FarServer::kSilentRegister}, &Arrival::address),
            1);
}

TEST(Downstream, DropsAnAnswerThatComesTooLate) {
  FarServer far;
  NearGateway near(far.port(), kImpatient);
  TcpClient client = near.client();
  EXPECT_EQ(ask(client, "03 0119 0001"), "83 0B");
  EXPECT_EQ(ask_until_answered(client, kRead), "03 02 03 F2");
  EXPECT_EQ(ask_until_answered(client, "03 000B 0001"), "03 02 03 F3");
}

TEST(Downstream, PassesExceptionsUnchanged) {
  FarServer far;
  NearGateway near(far.port(), kPatient);
  TcpClient client = near.client();
  EXPECT_EQ(ask(client, "03 1000 0001"), "83 02");
  EXPECT_EQ(ask(client, "03 011A 0001"), "83 11");
  EXPECT_EQ(ask(client, "06 011B 0001"), "86 0A");
}

TEST(Downstream, ConnectsAgainWhenTheServerIsBack) {
  std::optional<FarServer> far(std::in_place);
  const std::uint16_t port = far->port();
  NearGateway near(port, kPatient);
  TcpClient client = near.client();
  far.reset();
  EXPECT_EQ(ask(client, "06 0014 0001"), "86 0A");
  near.process().wait_for_line("bus far: cannot connect to tcp://127.0.0.1:" +
                               std::to_string(port) + ": Connection refused");
  far.emplace(port);
  EXPECT_TRUE(serves(client));
  EXPECT_EQ(ask(client, "06 0014 0001"), "06 00 14 00 01");
}

TEST(Downstream, GivesWhatWasOnItsWay0BWhenTheServerGoes) {
  std::optional<FarServer> far(std::in_place);
  NearGateway near(far->port(), kPatient);
  TcpClient client = near.client();
  const std::size_t before = far->arrivals().size();
  client.send(request(1, kUnit, "06 0118 0001"));
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (far->arrivals().size() == before && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
  }
  far.reset();
  EXPECT_EQ(pdu_of(client.receive()), "86 0B");
}

TEST(Chain, CarriesRequestsThroughTwoGateways) {
  Plant plant;
  NearGateway near(plant.port(0), kPatient);
  TcpClient client = near.client();
  TcpClient direct(plant.port(0));
  EXPECT_EQ(ask(client, "10 001E 0002 04 0003 0D40"), "10 00 1E 00 02");
  EXPECT_EQ(ask(direct, "03 001E 0002"), "03 04 00 03 0D 40");
  EXPECT_EQ(ask(client, "03 001E 0002"), "03 04 00 03 0D 40");
  EXPECT_EQ(ask(client, "03 001E 0002", 2), ask(direct, "03 001E 0002", 2));
}

TEST(Chain, PassesWhatTheFarGatewaySaysOfItsDevices) {
  {
    Plant plant({.response_timeout = "300ms"});
    NearGateway near(plant.port(0), kPatient);
    TcpClient client = near.client();
    EXPECT_EQ(ask(client, "06 001E 0001", 9), "86 0B");  // nobody has address 9
  }
  Plant plant;
  NearGateway near(plant.port(0), kPatient);
  TcpClient client = near.client();
  TcpClient direct(plant.port(0));
  const std::string refused = ask(direct, "03 7000 0001");
  EXPECT_TRUE(refused.starts_with("83")) << refused;
  EXPECT_EQ(ask(client, "03 7000 0001"), refused);
}

TEST(Chain, KeepsTheAnswersOfManyClientsApart) {
  Plant plant;
  NearGateway near(plant.port(0), kPatientWithFour);
  TcpClient preparing = near.client();
  ASSERT_EQ(ask(preparing, "10 001E 0002 04 0000 0001", 1), "10 00 1E 00 02");
  ASSERT_EQ(ask(preparing, "10 001E 0002 04 0000 0002", 2), "10 00 1E 00 02");
  std::vector<std::thread> threads;
  threads.reserve(6);
  std::atomic<int> wrong{0};
  for (unsigned number = 0; number < 6; ++number) {
    threads.emplace_back([&near, number, &wrong] {
      TcpClient client = near.client();
      const unsigned unit = 1 + number % 2;
      const std::string expected = "03 04 00 00 00 0" + std::to_string(unit);
      for (int round = 0; round < 50; ++round) {
        wrong += ask(client, "03 001E 0002", unit) == expected ? 0 : 1;
      }
    });
  }
  for (auto& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace mbgate::test

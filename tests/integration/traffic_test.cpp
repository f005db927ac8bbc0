// SPDX-License-Identifier: Apache-2.0
// Many clients, much traffic, through the real programs.
#include <gtest/gtest.h>
#include <poll.h>

#include <csignal>
#include <map>

#include "integration/plant.hpp"

namespace mbgate::test::traffic_test {
namespace {

constexpr int kClients = 64;
constexpr unsigned kFirst = 0x3C;  // MOONS' user registers: 44 of any value

std::string hex16(unsigned value) {
  char text[8];
  std::snprintf(text, sizeof text, "%04X", value);
  return text;
}

unsigned value_of(int bus, unsigned unit, unsigned address) {
  return static_cast<unsigned>(bus) * 20'000 + unit * 5'000 + address;
}

// Gives every user register its own value, so that each answer tells where it came from.
void fill(Plant& plant) {
  for (int bus = 0; bus < 2; ++bus) {
    TcpClient client(plant.port(bus));
    for (unsigned unit = 1; unit <= 2; ++unit) {
      std::string pdu = "10 " + hex16(kFirst) + " 002C 58 ";
      for (unsigned at = 0; at < 44; ++at) {
        pdu += hex16(value_of(bus, unit, kFirst + at));
      }
      ASSERT_TRUE(client.send(request(unit, unit, pdu)));
      const auto answer = client.receive();
      ASSERT_TRUE(answer);
      EXPECT_EQ(text_of(*answer).substr(21), "10 00 3C 00 2C");
    }
  }
}

struct Asker {
  Asker(std::uint16_t port, int on_bus) : client(port), bus(on_bus) {}
  TcpClient client;
  int bus;
  unsigned sent = 0;
  unsigned answered = 0;
  std::map<unsigned, ByteString> expected;

  ByteString next(unsigned number) {
    const unsigned unit = 1 + (sent + number) % 2;
    const unsigned address = kFirst + (sent * 7 + number * 3) % 40;
    const unsigned count = 1 + (sent + number) % 4;
    std::string answer = "03 " + hex16(count * 2).substr(2);
    for (unsigned at = 0; at < count; ++at) {
      answer += hex16(value_of(bus, unit, address + at));
    }
    const unsigned transaction = (sent + number * 1000) & 0xFFFFU;
    expected[transaction] = request(transaction, unit, answer);
    ++sent;
    return request(transaction, unit, "03 " + hex16(address) + hex16(count));
  }
  void take(const ByteString& answer) {
    const unsigned transaction = static_cast<unsigned>(answer[0]) << 8U | answer[1];
    const auto found = expected.find(transaction);
    ASSERT_NE(found, expected.end()) << "not asked, or answered twice: " << text_of(answer);
    EXPECT_EQ(text_of(answer), text_of(found->second));
    expected.erase(found);
    ++answered;
  }
};

std::vector<Asker> connect_all(Plant& plant) {
  std::vector<Asker> askers;
  askers.reserve(kClients);
  for (int number = 0; number < kClients; ++number) {
    askers.emplace_back(plant.port(number % 2), number % 2);
  }
  return askers;
}

TEST(Plant, SixtyFourClientsGetAThousandAnswersEachAndEveryOneIsTheirOwn) {
  constexpr unsigned kRequests = 1000;
  constexpr unsigned kDepth = 4;
  PlantOptions options;
  options.listener = "max_requests_per_second = 0";  // a fast machine has more
  Plant plant(options);
  fill(plant);
  auto askers = connect_all(plant);
  std::vector<pollfd> watched;
  for (unsigned number = 0; number < kClients; ++number) {
    for (unsigned depth = 0; depth < kDepth; ++depth) {
      askers[number].client.send(askers[number].next(number));
    }
    watched.push_back({askers[number].client.descriptor(), POLLIN, 0});
  }
  unsigned answered = 0;
  while (answered < kClients * kRequests) {
    ASSERT_GT(poll(watched.data(), watched.size(), 20'000), 0) << answered << " answers";
    for (unsigned number = 0; number < kClients; ++number) {
      if (watched[number].revents == 0) {
        continue;
      }
      Asker& asker = askers[number];
      while (const auto answer = asker.client.receive(0)) {
        asker.take(*answer);
        ++answered;
        if (asker.sent < kRequests) {
          asker.client.send(asker.next(number));
        }
      }
      ASSERT_FALSE(testing::Test::HasFailure()) << "client " << number;
    }
  }
  for (const Asker& asker : askers) {
    EXPECT_EQ(asker.answered, kRequests);
    EXPECT_TRUE(asker.expected.empty());
  }
}

TEST(Plant, RequestsSplitAtEveryByteAndTwentyInOneSegmentGiveTheSameAnswers) {
  constexpr unsigned kTogether = 20;
  Plant plant;
  fill(plant);
  auto askers = connect_all(plant);
  for (unsigned number = 0; number < kClients; ++number) {
    ByteString all;
    for (unsigned at = 0; at < kTogether; ++at) {
      const auto adu = askers[number].next(number);
      all.insert(all.end(), adu.begin(), adu.end());
    }
    if (number % 2 == 0) {
      askers[number].client.send(all);  // one segment
    } else {
      for (const auto byte : all) {  // one segment a byte
        askers[number].client.send({byte});
      }
    }
  }
  for (auto& asker : askers) {
    for (unsigned at = 0; at < kTogether; ++at) {
      const auto answer = asker.client.receive();
      ASSERT_TRUE(answer);
      asker.take(*answer);
    }
  }
}

TEST(Plant, KeepsTheSilenceOnAPacedLine) {
  PlantOptions options;
  options.paced = true;
  Plant plant(options);
  TcpClient client(plant.port(0));
  for (unsigned round = 0; round < 50; ++round) {
    client.send(request(round, 1, "03 003C 0002"));
    ASSERT_TRUE(client.receive());
  }
  plant.simulator.signal(SIGTERM);
  EXPECT_EQ(plant.simulator.wait_for_exit(), 0);
  EXPECT_NE(plant.simulator.output().find(
                "bus line-0: frames 50, answers 50, silence violations 0, collisions 0, "),
            std::string::npos)
      << plant.simulator.output();
}

}  // namespace
}  // namespace mbgate::test::traffic_test

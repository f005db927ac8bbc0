// SPDX-License-Identifier: Apache-2.0
// Thirty-two clients at addresses of their own, through the real programs: how they share a bus,
// and how many answers one transmission gives.
#include <gtest/gtest.h>
#include <poll.h>

#include <algorithm>
#include <deque>

#include "integration/plant.hpp"
#include "integration/scripted_devices.hpp"

namespace mbgate::test {
namespace {

constexpr unsigned kClients = 32;
constexpr unsigned kFirst = 0x3C;  // MOONS' user registers: 44 of any value

std::string hex16(unsigned value) {
  char text[8];
  std::snprintf(text, sizeof text, "%04X", value);
  return text;
}

/// Clients 127.0.0.2 and following, all served by one thread.
class Crowd {
 public:
  explicit Crowd(std::uint16_t port) {
    for (unsigned number = 0; number < kClients; ++number) {
      clients_.emplace_back(port, ("127.0.0." + std::to_string(2 + number)).c_str());
      watched_.push_back({clients_.back().descriptor(), POLLIN, 0});
    }
  }
  TcpClient& operator[](unsigned number) { return clients_[number]; }
  /// Gives each answer that comes to `take`, until that returns false; false if none comes.
  template <typename Take>
  bool serve(Take take) {
    for (;;) {
      if (poll(watched_.data(), watched_.size(), 20'000) <= 0) {
        return false;
      }
      for (unsigned number = 0; number < kClients; ++number) {
        if (watched_[number].revents == 0) {
          continue;
        }
        while (const auto answer = clients_[number].receive(0)) {
          if (!take(number, *answer)) {
            return true;
          }
        }
      }
    }
  }

 private:
  std::deque<TcpClient> clients_;
  std::vector<pollfd> watched_;
};

// Client 0 has 200 reads outstanding, each of the others one. No two ask for the same.
TEST(ManyClients, ShareABusEquallyThoughOneHasTwoHundredRequestsWaiting) {
  constexpr unsigned kRounds = 40;
  PlantOptions options;
  options.paced = true;
  options.listener = "pipeline = 200";
  Plant plant(options);
  Crowd crowd(plant.port(0));
  std::vector<unsigned> got(kClients);
  std::vector<unsigned> sent(kClients);
  const auto ask = [&](unsigned number) {
    const unsigned turn = sent[number]++;
    const unsigned address = number == 0 ? kFirst + turn / 2 % 44 : kFirst + number;
    const unsigned count = number == 0 ? 1 : 2;
    crowd[number].send(request(turn & 0xFFFFU, 1 + turn % 2, "03" + hex16(address) + hex16(count)));
  };
  for (unsigned at = 0; at < 200; ++at) {
    ask(0);
  }
  for (unsigned number = 1; number < kClients; ++number) {
    ask(number);
  }
  unsigned others = 0;
  ASSERT_TRUE(crowd.serve([&](unsigned number, const ByteString& answer) {
    got[number] += answer[7] == 0x03 ? 1 : 0;
    others += number != 0 && answer[7] == 0x03 ? 1 : 0;
    ask(number);
    return others < (kClients - 1) * kRounds;
  }));
  const auto [least, most] = std::minmax_element(got.begin() + 1, got.end());
  std::printf("while the 31 got %u each: the least %u, the most %u, the greedy one %u\n", kRounds,
              *least, *most, got[0]);
  EXPECT_GE(*least, kRounds * 95 / 100);
  EXPECT_LE(*most, kRounds * 105 / 100);
}

// The silence between two transmissions is long enough for every client to come back.
TEST(ManyClients, ThatPollTheSameGetThirtyAnswersForEachTransmissionAndNoneIsOld) {
  constexpr unsigned kAnswers = kClients * 100;
  TemporaryFolder folder;
  ScriptedDevices devices(1);
  const auto config =
      folder.write("mbgate.toml",
                   "[[listen]]\nname = \"plant\"\nport = 0\nbus = \"a\"\n"
                   "[[bus]]\nname = \"a\"\ndevice = \"" +
                       devices.path(0) +
                       "\"\nbaud = 115200\nparity = \"none\"\nlisten_first = \"0ms\"\n"
                       "frame_gap = \"50ms\"\n");
  Process gateway("mbgated", {"--config", config.string()}, {folder.path(), {}});
  Crowd crowd(gateway.port_of("plant"));
  std::vector<unsigned> asked_at(kClients);  // so many requests had the device had
  const auto ask = [&](unsigned number) {
    asked_at[number] = devices.requests(0);
    crowd[number].send(request(number, 1, "03" + hex16(ScriptedDevices::kRequests) + "0001"));
  };
  for (unsigned number = 0; number < kClients; ++number) {
    ask(number);
  }
  unsigned answers = 0;
  unsigned old = 0;
  unsigned exceptions = 0;
  ASSERT_TRUE(crowd.serve([&](unsigned number, const ByteString& answer) {
    ++answers;
    if (answer[7] != 0x03) {
      ++exceptions;
    } else {
      const unsigned sampled = unsigned{answer[9]} << 8U | answer[10];
      old += sampled <= asked_at[number] ? 1 : 0;
    }
    ask(number);
    return answers < kAnswers;
  }));
  const double ratio = answers / static_cast<double>(devices.requests(0));
  std::printf("%u answers for %u transmissions: %.2f\n", answers, devices.requests(0), ratio);
  // In virtual time it is 32; here a machine that is busy may keep clients from being in time.
  EXPECT_GT(ratio, 16.0);
  EXPECT_EQ(old, 0U);
  EXPECT_EQ(exceptions, 0U);
}

}  // namespace
}  // namespace mbgate::test

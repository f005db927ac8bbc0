// SPDX-License-Identifier: Apache-2.0
// Thirty-two clients at addresses of their own, through the real programs: how they share a bus,
// and how many answers one transmission gives.
#include <gtest/gtest.h>
#include <poll.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <optional>

#include "integration/plant.hpp"
#include "integration/scripted_devices.hpp"

namespace mbgate::test {
namespace {

constexpr unsigned kClients = 32;
/// Behind all that a client asks; the gateway's own answer to it says that it has read the rest.
const ByteString kMarking = request(0xFFFF, 0xF9, "03 0000 0001");

std::string hex16(unsigned value) {
  char text[8];
  std::snprintf(text, sizeof text, "%04X", value);
  return text;
}

bool is_mark(const ByteString& answer) { return answer[0] == 0xFF && answer[1] == 0xFF; }

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
      if (poll(watched_.data(), watched_.size(), 60'000) <= 0) {
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

/// A bus whose device holds back the answer to a first read until every client has asked.
class ManyClients : public testing::Test {
 protected:
  void start(const std::string& listener, const std::string& bus) {
    const auto config = folder_.write(
        "mbgate.toml", "[[listen]]\nname = \"plant\"\nport = 0\nbus = \"a\"\n" + listener +
                           "\n[[bus]]\nname = \"a\"\ndevice = \"" + devices_.path(0) +
                           "\"\nbaud = 115200\nparity = \"none\"\nlisten_first = \"0ms\"\n"
                           "response_timeout = \"60s\"\n" +
                           bus + "\n");
    gateway_.emplace("mbgated", std::vector<std::string>{"--config", config.string()},
                     Process::Options{folder_.path(), {}});
    crowd_.emplace(gateway_->port_of("plant"));
    blocking_.emplace(gateway_->port_of("plant"));
  }
  /// Each client asks what `asks_of` says, and all of it waits when the bus is free again.
  void ask_all(const std::function<ByteString(unsigned)>& asks_of) {
    devices_.hold(true);
    blocking_->send(request(1, 1, "03 0001 0001"));
    blocking_->send(kMarking);
    ASSERT_TRUE(blocking_->receive());  // the second one's answer: the read is on the wire
    for (unsigned number = 0; number < kClients; ++number) {
      (*crowd_)[number].send(asks_of(number));
      (*crowd_)[number].send(kMarking);
    }
    unsigned marks = 0;
    ASSERT_TRUE(crowd_->serve([&](unsigned, const ByteString& answer) {
      EXPECT_TRUE(is_mark(answer));
      return ++marks < kClients;
    }));
    devices_.hold(false);
    ASSERT_TRUE(blocking_->receive());
  }

  TemporaryFolder folder_;
  ScriptedDevices devices_{1};
  std::optional<Process> gateway_;
  std::optional<Crowd> crowd_;
  std::optional<TcpClient> blocking_;
};

// Client 0 has 63 reads waiting, each of the others twenty. Only the bus decides when an answer
// comes, until the first client has none left to wait for.
TEST_F(ManyClients, ShareABusEquallyThoughOneHasManyMoreRequestsWaiting) {
  constexpr unsigned kRounds = 20;
  start("", "coalesce = false\nframe_gap = \"0ms\"");
  ask_all([](unsigned number) {
    ByteString all;
    for (unsigned turn = 0; turn < (number == 0 ? 63 : kRounds); ++turn) {
      const auto adu = request(turn, 1, "03" + hex16(100 + number) + "0001");
      all.insert(all.end(), adu.begin(), adu.end());
    }
    return all;
  });
  std::vector<unsigned> got(kClients);
  ASSERT_TRUE(crowd_->serve([&](unsigned number, const ByteString& answer) {
    EXPECT_EQ(text_of({answer.begin() + 7, answer.end()}),
              "03 02 00 " + text_of({static_cast<std::uint8_t>(100 + number)}));
    return ++got[number] < kRounds;
  }));
  for (unsigned number = 0; number < kClients; ++number) {  // what had come too by then
    while ((*crowd_)[number].receive(0)) {
      ++got[number];
    }
  }
  const auto least = std::ranges::min_element(got);
  std::printf("when one had its %u: the least %u, the greedy one %u\n", kRounds, *least, got[0]);
  EXPECT_GE(*least, kRounds - 1);
}

TEST_F(ManyClients, ThatPollTheSameGetOneTransmissionForAllAndNoneIsOld) {
  constexpr unsigned kRounds = 20;
  start("", "");
  for (unsigned round = 0; round < kRounds; ++round) {
    ask_all([](unsigned number) {
      return request(number, 1, "03" + hex16(ScriptedDevices::kRequests) + "0001");
    });
    ASSERT_FALSE(HasFatalFailure());
    unsigned answers = 0;
    ASSERT_TRUE(crowd_->serve([&](unsigned, const ByteString& answer) {
      EXPECT_EQ(answer[7], 0x03);
      // Two transmissions a round, and this is the second one.
      EXPECT_EQ(unsigned{answer[9]} << 8U | answer[10], 2 * round + 2);
      return ++answers < kClients;
    }));
  }
  EXPECT_EQ(devices_.requests(0), 2 * kRounds);
}

}  // namespace
}  // namespace mbgate::test

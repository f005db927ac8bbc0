// SPDX-License-Identifier: Apache-2.0
// How old bytes are that waited in a client's socket while it was not read.
#include "gateway/clients/client_session.hpp"

#include <gtest/gtest.h>

namespace mbgate::gateway {
namespace {

using namespace std::chrono_literals;

class PausedSession : public testing::Test {
 protected:
  void pause_at(Instant now) {
    while (!session_.is_full()) {
      open_.push_back(session_.answers.open());
    }
    EXPECT_EQ(session_.update_reading(now), ClientSession::Reading::pause);
  }
  void resume_at(Instant now) {
    session_.answers.close(open_.back(), std::nullopt, now);
    open_.pop_back();
    EXPECT_EQ(session_.update_reading(now), ClientSession::Reading::resume);
  }

  const Instant start_{1s};
  ListenerSettings listener_;
  ClientSession session_{{}, {}, listener_, start_};
  std::vector<AnswerId> open_;
};

TEST_F(PausedSession, WhatIsReadIsAsOldAsTheFirstPauseUntilTheSocketWasEmpty) {
  pause_at(start_);
  resume_at(start_ + 1s);
  EXPECT_EQ(session_.arrival_of(30, start_ + 1s), start_);  // 30 bytes more lay behind them
  pause_at(start_ + 2s);
  resume_at(start_ + 3s);
  EXPECT_EQ(session_.arrival_of(0, start_ + 3s), start_);
  EXPECT_EQ(session_.arrival_of(0, start_ + 4s), start_ + 4s);
}

TEST_F(PausedSession, AStallCountsFromWhenTheSocketWasSeenEmpty) {
  EXPECT_EQ(session_.arrival_of(0, start_ + 1s), start_ + 1s);
  session_.stall(start_);
  EXPECT_EQ(session_.arrival_of(0, start_ + 3s), start_ + 1s);
}

TEST_F(PausedSession, WhatWaitedBeforeItWasAcceptedArrivedWhenItConnected) {
  for (const Instant connected : {start_ - 300ms, Instant::min()}) {
    ClientInfo info;
    info.waits_since = connected;
    ClientSession session{{}, info, listener_, start_};
    EXPECT_EQ(session.arrival_of(12, start_), connected);
    EXPECT_EQ(session.arrival_of(0, start_), connected);
    EXPECT_EQ(session.arrival_of(0, start_ + 1s), start_ + 1s);
  }
}

TEST(ClientInput, IsAsOldAsItsFirstByteAndWhatIsLeftAsOldAsTheLast) {
  ClientInput input;
  const std::vector<std::uint8_t> bytes(10);
  input.append(bytes, Instant{1s}, Instant{2s});
  input.append(bytes, Instant{3s}, Instant{4s});
  EXPECT_EQ(input.arrival(), Instant{1s});
  EXPECT_EQ(input.read_at(), Instant{4s});
  input.consume(15);
  EXPECT_EQ(input.bytes().size(), 5U);
  EXPECT_EQ(input.arrival(), Instant{3s});
}

}  // namespace
}  // namespace mbgate::gateway

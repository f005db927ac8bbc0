// SPDX-License-Identifier: Apache-2.0
// How old bytes are that waited in a client's socket while it was not read.
#include "gateway/clients/client_session.hpp"

#include <gtest/gtest.h>

#include "gateway/limits.hpp"

namespace mbgate::gateway {
namespace {

using namespace std::chrono_literals;

class PausedSession : public testing::Test {
 protected:
  PausedSession() { session_.answers.open(); }
  static ListenerSettings of_one() {
    ListenerSettings listener;
    listener.pipeline = 1;
    return listener;
  }
  void pause_at(Instant now) {
    session_.input.append(std::vector<std::uint8_t>(kReadAhead), now);
    EXPECT_EQ(session_.update_reading(now), ClientSession::Reading::pause);
  }
  void resume_at(Instant now) {
    session_.input.consume(kReadAhead);
    EXPECT_EQ(session_.update_reading(now), ClientSession::Reading::resume);
  }

  const Instant start_{1s};
  ListenerSettings listener_ = of_one();
  ClientSession session_{{}, {}, listener_, start_};
};

TEST_F(PausedSession, WhatLayThereBeforeALaterPauseIsAsOldAsTheFirst) {
  pause_at(start_);
  resume_at(start_ + 1s);
  EXPECT_EQ(session_.arrival_of(50, 30, start_ + 1s), start_);  // 30 more lay behind them
  pause_at(start_ + 2s);
  resume_at(start_ + 3s);
  EXPECT_EQ(session_.arrival_of(30, 20, start_ + 3s), start_);
  EXPECT_EQ(session_.arrival_of(20, 0, start_ + 3s), start_ + 2s);
  EXPECT_EQ(session_.arrival_of(10, 0, start_ + 3s), start_ + 3s);
}

TEST_F(PausedSession, NothingIsOlderThanTheConnection) {
  session_.stall(start_ - 1s);
  EXPECT_EQ(session_.arrival_of(50, 0, start_ + 2s), start_);
}

TEST_F(PausedSession, NorThanTheTimeAtWhichTheSocketWasSeenEmpty) {
  session_.arrival_of(50, 0, start_ + 1s);
  session_.arrival_of(50, 30, start_ + 3s);
  session_.stall(start_ + 500ms);
  EXPECT_EQ(session_.arrival_of(30, 0, start_ + 4s), start_ + 1s);
  session_.stall(start_ + 5s);
  EXPECT_EQ(session_.arrival_of(50, 0, start_ + 6s), start_ + 5s);
}

TEST_F(PausedSession, BehindTlsItMayHaveWaitedElsewhere) {
  ClientInfo info;
  info.role = {routing::ClientRole::Kind::named, "operator"};
  ClientSession session{{}, info, listener_, start_};
  session.arrival_of(50, 0, start_ + 1s);
  session.stall(start_ + 500ms);
  EXPECT_EQ(session.arrival_of(50, 0, start_ + 2s), start_ + 500ms);
}

}  // namespace
}  // namespace mbgate::gateway

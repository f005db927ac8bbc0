// SPDX-License-Identifier: Apache-2.0
#include "bus/health/line_quality.hpp"

#include <gtest/gtest.h>

namespace mbgate::test {
namespace {

using namespace std::chrono_literals;
using bus::Quality;

class LineQuality : public testing::Test {
 protected:
  void answers(std::uint8_t address, int good, int bad) {
    for (int at = 0; at < good; ++at) {
      quality_[address].note_answered();
      quality_.note_answer(false);
      tell(address);
    }
    for (int at = 0; at < bad; ++at) {
      quality_[address].note_damaged();
      quality_.note_answer(true);
      tell(address);
    }
  }
  void tell(std::uint8_t address) {
    while (const auto change = quality_.take_change(address)) {
      (change->address ? of_device_ : of_line_).push_back(change->verdict.quality);
    }
  }
  const bus::QualityVerdict& verdict() { return quality_[1].verdict(); }

  bus::LineQuality quality_;
  std::vector<Quality> of_device_;
  std::vector<Quality> of_line_;
};

TEST_F(LineQuality, BadCrcsAreToldWithTheirShareUntilTheyHaveBecomeRare) {
  answers(1, 6, 4);
  EXPECT_EQ(verdict().quality, Quality::good);
  answers(1, 0, 1);
  EXPECT_EQ(verdict().quality, Quality::bad_crc);
  EXPECT_EQ(verdict().count, 5U);
  EXPECT_EQ(verdict().of, 11U);
  EXPECT_EQ(verdict().percent(), 45U);
  answers(1, 200, 0);
  EXPECT_EQ(verdict().quality, Quality::good);
  EXPECT_EQ(of_device_, (std::vector{Quality::bad_crc, Quality::good}));
  EXPECT_TRUE(of_line_.empty());
}

TEST_F(LineQuality, AFewBadCrcsOfManyAreNotWorthALine) {
  answers(1, 150, 5);
  EXPECT_EQ(verdict().quality, Quality::good);
  EXPECT_TRUE(of_device_.empty());
}

TEST_F(LineQuality, OneBadCrcInTwentyIsEnough) {
  answers(1, 95, 4);
  EXPECT_EQ(verdict().quality, Quality::good);
  answers(1, 0, 1);
  EXPECT_EQ(verdict().quality, Quality::bad_crc);
}

TEST_F(LineQuality, BadCrcsAreRareBelowOneInFifty) {
  answers(1, 0, 9);
  answers(1, 291, 0);  // beyond 200 the counts are halved: 4 of 200
  EXPECT_EQ(verdict().quality, Quality::bad_crc);
  answers(1, 1, 0);
  EXPECT_EQ(verdict().quality, Quality::good);
}

TEST_F(LineQuality, BadCrcsOfTwoDevicesAreAMatterOfTheLine) {
  answers(1, 0, 5);
  EXPECT_EQ(quality_.verdict().quality, Quality::good);
  answers(2, 5, 5);
  EXPECT_EQ(quality_.verdict().quality, Quality::bad_crc);
  EXPECT_EQ(quality_.verdict().percent(), 66U);
  EXPECT_EQ(of_line_, std::vector{Quality::bad_crc});
}

TEST_F(LineQuality, BytesAfterEachRequestAndNeverAFrame) {
  for (int at = 0; at < 4; ++at) {
    quality_[1].note_unreadable(30ms + at * 5ms, 0);
  }
  EXPECT_EQ(verdict().quality, Quality::unknown);
  quality_[1].note_unreadable(31ms, 0);
  EXPECT_EQ(verdict().quality, Quality::no_frame);
  EXPECT_EQ(verdict().of, 5U);
  answers(1, 1, 0);
  EXPECT_EQ(verdict().quality, Quality::good);
}

// By a frame that answers nothing it was understood too.
TEST_F(LineQuality, BytesAreNoVerdictOnWhoWasHeard) {
  quality_[1].note_heard();
  EXPECT_TRUE(quality_[1].has_answered());
  quality_[2].note_misfit();
  for (int at = 0; at < 4; ++at) {
    quality_[1].note_unreadable(30ms, 0);
    quality_[2].note_unreadable(30ms, 0);
  }
  EXPECT_EQ(quality_[2].verdict().quality, Quality::unknown);
  quality_[1].note_unreadable(30ms, 0);
  EXPECT_EQ(verdict().quality, Quality::unknown);
}

// A drive that answers when its program comes round.
TEST_F(LineQuality, WhereTheTimesDifferMoreAreNeeded) {
  for (int at = 0; at < 11; ++at) {
    quality_[1].note_unreadable(at % 3 * 25ms, 0);
  }
  EXPECT_EQ(verdict().quality, Quality::unknown);
  quality_[1].note_unreadable(10ms, 0);
  EXPECT_EQ(verdict().quality, Quality::no_frame);
  EXPECT_EQ(verdict().of, 12U);
}

// Noise comes at any time, and while nobody asks too; a device that was understood speaks right.
TEST_F(LineQuality, WhatNoiseOrDamageCouldExplainIsNotSaid) {
  for (int at = 0; at < 20; ++at) {
    quality_[1].note_unreadable(at * 30ms, 0);
    quality_[2].note_unreadable(30ms, static_cast<unsigned>(at));
    quality_[3].note_unreadable(30ms, 0);
    if (at % 4 == 3) {
      quality_[3].note_silent();
    }
  }
  answers(4, 1, 0);
  for (int at = 0; at < 20; ++at) {
    quality_[4].note_unreadable(30ms, 0);
  }
  for (std::uint8_t address = 1; address <= 3; ++address) {
    EXPECT_EQ(quality_[address].verdict().quality, Quality::unknown);
  }
  EXPECT_EQ(quality_[4].verdict().quality, Quality::good);
}

TEST_F(LineQuality, AnswersThatAreLateAgainAndAgainSayWhichTimeoutWouldDo) {
  for (int at = 0; at < 4; ++at) {
    EXPECT_EQ(verdict().quality, Quality::unknown);
    quality_[1].note_silent();
    quality_[1].note_late(100ms + at * 5ms, 300ms);
  }
  EXPECT_EQ(verdict().quality, Quality::late);
  EXPECT_EQ(verdict().count, 4U);
  EXPECT_EQ(verdict().of, 4U);
  EXPECT_EQ(verdict().lateness, 115ms);
  EXPECT_EQ(verdict().needed, 450ms);  // a quarter of 115 ms more, in steps of 10 ms
  answers(1, 16, 0);
  EXPECT_EQ(verdict().quality, Quality::good);
}

TEST_F(LineQuality, WhatDoesNotFitWasInTimeToo) {
  for (int at = 0; at < 4; ++at) {
    quality_[1].note_silent();
    quality_[1].note_late(100ms, 300ms);
  }
  for (int at = 0; at < 15; ++at) {
    quality_[1].note_misfit();
  }
  answers(1, 1, 0);
  EXPECT_EQ(verdict().quality, Quality::good);
}

TEST_F(LineQuality, TheLargestLatenessIsOneOfTheLastRequests) {
  for (const auto lateness : {500ms, 100ms}) {
    for (int at = 0; at < 4; ++at) {
      quality_[1].note_silent();
      quality_[1].note_late(lateness, 300ms);
    }
    EXPECT_EQ(verdict().lateness, lateness);
    answers(1, 16, 0);
  }
}

// A drive that stood still sends all that it owes at once when it goes on.
TEST_F(LineQuality, ManyLateAnswersAtOnceAreOneEvent) {
  for (int at = 0; at < 8; ++at) {
    quality_[1].note_silent();
  }
  for (int at = 0; at < 8; ++at) {
    quality_[1].note_late(5s, 300ms);
  }
  EXPECT_EQ(verdict().quality, Quality::unknown);
  EXPECT_TRUE(quality_[1].has_answered());
}

// Five times bytes, and then the cable is pulled.
TEST_F(LineQuality, BytesWithoutAFrameAreNoVerdictOnWhoIsSilentNow) {
  const auto unreadable = [this] {
    for (int at = 0; at < 5; ++at) {
      quality_[1].note_unreadable(30ms, 0);
      tell(1);
    }
  };
  unreadable();
  ASSERT_EQ(verdict().quality, Quality::no_frame);
  quality_[1].note_silent();
  tell(1);
  EXPECT_EQ(verdict().quality, Quality::unknown);
  unreadable();
  EXPECT_EQ(verdict().quality, Quality::no_frame);
  EXPECT_EQ(of_device_,
            std::vector{Quality::no_frame});  // silence is no news, nor is the same again
  answers(1, 1, 0);
  EXPECT_EQ(of_device_, (std::vector{Quality::no_frame, Quality::good}));
}

// Late answers alone, and then its power is off.
TEST_F(LineQuality, LateAnswersAreNoVerdictOnceTheLastRequestsHadNone) {
  for (int at = 0; at < 4; ++at) {
    quality_[1].note_silent();
    quality_[1].note_late(100ms, 300ms);
    tell(1);
  }
  for (int at = 0; at < 15; ++at) {
    quality_[1].note_silent();
    tell(1);
  }
  EXPECT_EQ(verdict().quality, Quality::late);
  quality_[1].note_silent();
  tell(1);
  EXPECT_EQ(verdict().quality, Quality::unknown);
  EXPECT_EQ(of_device_, std::vector{Quality::late});
}

TEST_F(LineQuality, AnotherDeviceIsJudgedAnewAndTheLineWithoutTheOneBefore) {
  answers(1, 1, 5);
  answers(2, 1, 5);
  answers(3, 1, 0);
  quality_.forget(3);
  answers(4, 1, 5);
  quality_.forget(4);
  ASSERT_EQ(quality_.verdict().quality, Quality::bad_crc);
  quality_.forget(1);
  EXPECT_EQ(verdict().quality, Quality::unknown);
  EXPECT_FALSE(quality_[1].has_answered());
  EXPECT_TRUE(quality_[2].has_answered());
  EXPECT_EQ(quality_.verdict().quality, Quality::good);
}

TEST_F(LineQuality, AnotherLineIsJudgedAnew) {
  answers(1, 0, 5);
  quality_.forget();
  EXPECT_EQ(verdict().quality, Quality::unknown);
  answers(1, 0, 5);
  EXPECT_EQ(of_device_, (std::vector{Quality::bad_crc, Quality::bad_crc}));
}

}  // namespace
}  // namespace mbgate::test

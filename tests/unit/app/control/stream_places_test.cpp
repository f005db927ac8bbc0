// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>

#include "app/control/stream_readers.hpp"

namespace mbgate::app {
namespace {

constexpr bool kOverTcp = true;
constexpr bool kOverSocket = false;

TEST(StreamPlaces, AreForWhoeverComesFirst) {
  StreamPlaces places(2);
  const Counted socket = places.take(kOverSocket);
  EXPECT_EQ(places.refusal(kOverTcp), std::nullopt);
  {
    const Counted second = places.take(kOverTcp);
    const char* const full =
        "2 clients already follow events or the trace; [http] max_streams allows 2";
    EXPECT_EQ(places.refusal(kOverSocket), full);
    EXPECT_EQ(places.refusal(kOverTcp), full);
  }
  EXPECT_EQ(places.refusal(kOverSocket), std::nullopt);
  EXPECT_EQ(places.refusal(kOverTcp), std::nullopt);
}

TEST(StreamPlaces, AreAQuarterForTheUnixSocketAlone) {
  StreamPlaces places(8);
  const std::array<Counted, 5> taken{places.take(kOverTcp), places.take(kOverTcp),
                                     places.take(kOverTcp), places.take(kOverTcp),
                                     places.take(kOverTcp)};
  EXPECT_EQ(places.refusal(kOverTcp), std::nullopt);
  const Counted sixth = places.take(kOverTcp);
  EXPECT_EQ(
      places.refusal(kOverTcp),
      "6 clients already follow events or the trace over TCP; [http] max_streams = 8 allows 6 "
      "there");
  EXPECT_EQ(places.refusal(kOverSocket), std::nullopt);
}

TEST(StreamPlaces, AreAllOfThemForTheUnixSocketIfItComesFirst) {
  StreamPlaces places(2);
  const Counted first = places.take(kOverSocket);
  EXPECT_EQ(places.refusal(kOverSocket), std::nullopt);
  const Counted second = places.take(kOverSocket);
  EXPECT_NE(places.refusal(kOverTcp), std::nullopt);
}

TEST(StreamPlaces, OfWhichThereIsOneAreNotForTcp) {
  const StreamPlaces places(1);
  EXPECT_EQ(
      places.refusal(kOverTcp),
      "0 clients already follow events or the trace over TCP; [http] max_streams = 1 allows 0 "
      "there");
  EXPECT_EQ(places.refusal(kOverSocket), std::nullopt);
}

}  // namespace
}  // namespace mbgate::app

// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <vector>

#include "app/control/stream_readers.hpp"

namespace mbgate::app {
namespace {

const StreamPlaces::Reader kSocket{"uid 0", false};

StreamPlaces::Reader over_tcp(int client) { return {fmt::format("192.0.2.{}", client), true}; }

TEST(StreamPlaces, AreForWhoeverComesFirst) {
  StreamPlaces places(2);
  const auto socket = places.take(kSocket);
  EXPECT_EQ(places.refusal(over_tcp(1)), std::nullopt);
  {
    const auto second = places.take(over_tcp(1));
    const char* const full =
        "2 clients already follow events or the trace; [http] max_streams allows 2";
    EXPECT_EQ(places.refusal({"uid 1000", false}), full);
    EXPECT_EQ(places.refusal(over_tcp(2)), full);
  }
  EXPECT_EQ(places.refusal({"uid 1000", false}), std::nullopt);
  EXPECT_EQ(places.refusal(over_tcp(2)), std::nullopt);
}

TEST(StreamPlaces, AreAQuarterForTheUnixSocketAlone) {
  StreamPlaces places(8);
  std::vector<StreamPlaces::Place> taken;
  for (int client = 1; client <= 6; ++client) {
    EXPECT_EQ(places.refusal(over_tcp(client)), std::nullopt);
    taken.push_back(places.take(over_tcp(client)));
  }
  EXPECT_EQ(
      places.refusal(over_tcp(7)),
      "6 clients already follow events or the trace over TCP; [http] max_streams = 8 allows 6 "
      "there");
  EXPECT_EQ(places.refusal(kSocket), std::nullopt);
}

TEST(StreamPlaces, AreAQuarterForOneClient) {
  StreamPlaces places(8);
  const auto first = places.take(over_tcp(1));
  {
    const auto second = places.take(over_tcp(1));
    EXPECT_EQ(places.refusal(over_tcp(1)),
              "2 readers of this address or user already follow events or the trace; [http] "
              "max_streams = 8 "
              "allows 2 of each");
    EXPECT_EQ(places.refusal(over_tcp(2)), std::nullopt);
  }
  EXPECT_EQ(places.refusal(over_tcp(1)), std::nullopt);
}

TEST(StreamPlaces, AreOneAtLeastForEachClient) {
  StreamPlaces places(3);
  const auto first = places.take(kSocket);
  EXPECT_NE(places.refusal(kSocket), std::nullopt);
  EXPECT_EQ(places.refusal(over_tcp(1)), std::nullopt);
}

TEST(StreamPlaces, OfWhichThereIsOneAreNotForTcp) {
  const StreamPlaces places(1);
  EXPECT_EQ(
      places.refusal(over_tcp(1)),
      "0 clients already follow events or the trace over TCP; [http] max_streams = 1 allows 0 "
      "there");
  EXPECT_EQ(places.refusal(kSocket), std::nullopt);
}

}  // namespace
}  // namespace mbgate::app

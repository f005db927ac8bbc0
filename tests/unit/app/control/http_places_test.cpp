// SPDX-License-Identifier: Apache-2.0
#include "app/control/http_places.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace mbgate::app {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::size_t kMost = 4;
constexpr std::size_t kMostOfOne = 3;

/// Connections by their names, and which were closed for another.
class HttpPlacesTest : public testing::Test {
 protected:
  std::shared_ptr<HttpPlaces::Place> enter(const std::string& client, const std::string& name) {
    return places_.take(client, [this, name] { closed_.push_back(name); });
  }

  HttpPlaces places_{kMost, kMostOfOne};
  std::vector<std::string> closed_;
};

TEST_F(HttpPlacesTest, AreFreeAgainWithTheirConnections) {
  for (int i = 0; i < 10; ++i) {
    EXPECT_NE(enter("a", "a1"), nullptr);
  }
  EXPECT_THAT(closed_, IsEmpty());
}

TEST_F(HttpPlacesTest, OfOneClientThatHasAllItMayHaveGoToItsOwn) {
  const auto first = enter("a", "a1");
  const auto second = enter("a", "a2");
  const auto third = enter("a", "a3");
  const auto other = enter("b", "b1");
  first->wait();  // it has asked meanwhile
  const auto fourth = enter("a", "a4");
  EXPECT_NE(fourth, nullptr);
  EXPECT_THAT(closed_, ElementsAre("a2"));
}

TEST_F(HttpPlacesTest, AreGivenUpByWhoHasTheMost) {
  const auto only = enter("b", "b1");
  const auto first = enter("a", "a1");
  const auto second = enter("a", "a2");
  const auto other = enter("c", "c1");
  first->answer(false);
  second->answer(false);
  second->wait();
  EXPECT_NE(enter("d", "d1"), nullptr);
  EXPECT_THAT(closed_, ElementsAre("a2"));
}

TEST_F(HttpPlacesTest, AreGivenUpByTheLongestIdleWhereAllHaveOne) {
  const auto first = enter("a", "a1");
  const auto second = enter("b", "b1");
  const auto third = enter("c", "c1");
  const auto fourth = enter("d", "d1");
  first->wait();
  EXPECT_NE(enter("e", "e1"), nullptr);
  EXPECT_THAT(closed_, ElementsAre("b1"));
}

TEST_F(HttpPlacesTest, WhereAllAreAnsweredAreGivenUpByTheOldest) {
  const auto first = enter("a", "a1");
  const auto second = enter("a", "a2");
  const auto third = enter("a", "a3");
  second->answer(false);
  first->answer(false);
  third->answer(false);
  EXPECT_NE(enter("a", "a4"), nullptr);
  EXPECT_THAT(closed_, ElementsAre("a2"));
}

TEST_F(HttpPlacesTest, AreKeptForAMomentByWhoHasJustCome) {
  const auto first = enter("a", "a1");
  const auto second = enter("a", "a2");
  const auto third = enter("a", "a3");
  second->answer(false);
  second->wait();
  EXPECT_NE(enter("a", "a4"), nullptr);
  EXPECT_THAT(closed_, ElementsAre("a2"));
}

TEST_F(HttpPlacesTest, OfCommandsAreNotGivenUp) {
  const auto first = enter("a", "a1");
  const auto second = enter("a", "a2");
  const auto third = enter("a", "a3");
  for (const auto& place : {first, second, third}) {
    place->answer(true);
  }
  EXPECT_EQ(enter("a", "a4"), nullptr);
  EXPECT_NE(enter("b", "b1"), nullptr);
  EXPECT_THAT(closed_, IsEmpty());
}

TEST_F(HttpPlacesTest, AreTakenFromEachConnectionOnce) {
  const auto first = enter("a", "a1");
  const auto second = enter("a", "a2");
  const auto third = enter("a", "a3");
  const auto fourth = enter("a", "a4");
  const auto fifth = enter("a", "a5");
  EXPECT_THAT(closed_, ElementsAre("a1", "a2"));
}

}  // namespace
}  // namespace mbgate::app

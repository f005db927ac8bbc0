// SPDX-License-Identifier: Apache-2.0
#include "ctl/control/connection_shell.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace mbgate::ctl {
namespace {

using boost::system::error_code;
using std::chrono::hours;
using std::chrono::steady_clock;

const error_code kUnreachable = make_error_code(boost::system::errc::host_unreachable);

TEST(PlacesInTurn, EachButTheLastGetsAShareOfTheTime) {
  const std::function<bool()> never;
  const WaitLimit limit{steady_clock::now() + hours(3), never};
  std::vector<steady_clock::time_point> ends;
  const auto error = try_in_turn(3, limit, [&](std::size_t, const WaitLimit& share) {
    ends.push_back(share.end);
    return kUnreachable;
  });
  EXPECT_EQ(error, kUnreachable);
  ASSERT_EQ(ends.size(), 3U);
  EXPECT_LT(ends[0], limit.end - hours(1));
  EXPECT_LT(ends[1], limit.end);
  EXPECT_EQ(ends[2], limit.end);
}

TEST(PlacesInTurn, EndWithTheFirstThatIsReached) {
  const std::function<bool()> never;
  std::vector<std::size_t> tried;
  const auto error = try_in_turn(3, {steady_clock::now() + hours(1), never},
                                 [&](std::size_t place, const WaitLimit&) {
                                   tried.push_back(place);
                                   return place == 1 ? error_code() : kUnreachable;
                                 });
  EXPECT_FALSE(error);
  EXPECT_EQ(tried, (std::vector<std::size_t>{0, 1}));
}

TEST(PlacesInTurn, EndWithTheWishToGiveUp) {
  bool is_given_up = false;
  const std::function<bool()> give_up = [&] { return is_given_up; };
  std::size_t tries = 0;
  const auto error = try_in_turn(3, {steady_clock::now() + hours(1), give_up},
                                 [&](std::size_t, const WaitLimit& share) {
                                   ++tries;
                                   is_given_up = true;
                                   EXPECT_TRUE(share.is_over());
                                   return kUnreachable;
                                 });
  EXPECT_EQ(error, kUnreachable);
  EXPECT_EQ(tries, 1U);
}

}  // namespace
}  // namespace mbgate::ctl

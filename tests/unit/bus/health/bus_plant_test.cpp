// SPDX-License-Identifier: Apache-2.0
// No answer goes to the wrong request, however late, often or seldom drives answer; and clients are
// served all the same.
#include "plant_rig.hpp"

namespace mbgate::test {
namespace {

constexpr auto kTimeout = 100ms;
constexpr auto kRun = 10min;

struct Slow {
  double factor;  // of the response timeout
  unsigned retries;
};

class BusSlowDrive : public Plant, public testing::WithParamInterface<Slow> {
 protected:
  void start() {
    auto slow = settings();
    slow.timing.retries = GetParam().retries;
    slow.timing.offline_after = 3;
    slow.coalesce = true;
    open(slow);
    drive_.service = std::chrono::duration_cast<Duration>(kTimeout * GetParam().factor);
  }
};

TEST_P(BusSlowDrive, NeverAnswersAnotherRequestAndServes) {
  start();
  add_client({"03 0064 0001", "04 0002 0001", "06 0001 VVVV"});
  add_client({"03 0007 0001", "10 0001 0001 02 VVVV", "03 0008 0001"});
  const Duration at_start = 20 * kTimeout;
  run(at_start);
  const unsigned wrong_at_start = score_.wrong;
  run(kRun - at_start);
  RecordProperty("wrong", static_cast<int>(score_.wrong));
  std::printf("factor %.1f retries %u: right %u wrong %u failed %u\n", GetParam().factor,
              GetParam().retries, score_.right, score_.wrong, score_.failed);
  EXPECT_EQ(score_.wrong, wrong_at_start);
  EXPECT_LE(wrong_at_start, GetParam().retries > 0 && GetParam().factor <= 2.5 ? 0U : 5U);
}

TEST_P(BusSlowDrive, IsReadOnceInThreeServiceTimes) {
  start();
  add_client({"03 0064 0001", "03 0007 0001"});
  run(kRun);
  std::printf("factor %.1f retries %u: right %u wrong %u failed %u\n", GetParam().factor,
              GetParam().retries, score_.right, score_.wrong, score_.failed);
  if (GetParam().retries > 0 && GetParam().factor <= 1.9) {
    EXPECT_GE(score_.right, Duration(kRun) / (3 * drive_.service));
  }
}

std::vector<Slow> slow_drives() {
  std::vector<Slow> all;
  for (const double factor : {1.1, 1.3, 1.5, 1.7, 1.9, 2.1, 2.3, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0}) {
    for (const unsigned retries : {0U, 1U, 2U}) {
      all.push_back({factor, retries});
    }
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Drives, BusSlowDrive, testing::ValuesIn(slow_drives()));

struct Doubled {
  double share;
  Duration after;
};

class BusSecondAnswers : public Plant, public testing::WithParamInterface<Doubled> {};

TEST_P(BusSecondAnswers, AreGivenToNobodyOnceTheyAreKnown) {
  auto plain = settings();
  plain.timing.retries = 1;
  open(plain);
  drive_.doubled = GetParam().share;
  drive_.second_after = GetParam().after;
  add_client({"03 0000 0001", "10 0001 0001 02 VVVV"});
  add_client({"03 000A 0001"});
  run(kRun);
  std::printf("share %.2f after %ld ms: right %u wrong %u failed %u, last wrong at %.1f s\n",
              GetParam().share, static_cast<long>(GetParam().after / 1ms), score_.right,
              score_.wrong, score_.failed,
              static_cast<double>((score_.last_wrong - Instant{}) / 1ms) / 1000);
  EXPECT_LE(score_.wrong, 5U);
}

INSTANTIATE_TEST_SUITE_P(Drives, BusSecondAnswers,
                         testing::Values(Doubled{1, 9ms}, Doubled{1, 2ms}, Doubled{1, 40ms},
                                         Doubled{1, 80ms}, Doubled{0.3, 9ms}, Doubled{0.05, 9ms},
                                         Doubled{0.05, 40ms}, Doubled{0.05, 80ms}));

class BusLostAnswers : public Plant {};

TEST_F(BusLostAnswers, AreAskedForAgain) {
  auto plain = settings();
  plain.timing.retries = 1;
  open(plain);
  drive_.lost = 0.02;
  add_client({"03 0000 0001", "06 0001 VVVV"});
  add_client({"03 000A 0001"});
  add_client({"03 000B 0001"});
  run(kRun);
  std::printf("lost: right %u wrong %u failed %u\n", score_.right, score_.wrong, score_.failed);
  EXPECT_EQ(score_.wrong, 0U);
  EXPECT_LT(score_.failed, score_.right / 50);
}

}  // namespace
}  // namespace mbgate::test

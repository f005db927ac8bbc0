// SPDX-License-Identifier: Apache-2.0
// A merged read that fails, where one of those who share it asked for all of it.
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

constexpr auto kWhole = "03 0000 0002";
constexpr auto kWholeFrame = "01 03 00 00 00 02 C4 0B";
constexpr auto kPart = "03 0001 0001";
constexpr auto kPartFrame = "01 03 00 01 00 01 D5 CA";

class BusMergedRead : public Bus {
 protected:
  /// Both have waited, and are on the wire as one.
  void merge(unsigned retries) {
    auto merging = settings();
    merging.coalesce = true;
    merging.merge = true;
    merging.timing.retries = retries;
    open(merging);
    submit(job_of(99, kRead, 2));
    advance(10ms);
    submit(job_of(0, kWhole));
    submit(job_of(1, kPart));
    line("02 03 02 12 34 F1 33");
    advance(5ms);
    frames_.erase(frames_.begin());
    endings_.erase(endings_.begin());
    ASSERT_THAT(frames_, ElementsAre(kWholeFrame));
  }
};

TEST_F(BusMergedRead, WhoAskedForAllOfItIsNotTriedOnceMore) {
  merge(1);
  advance(1s);
  EXPECT_THAT(frames_, ElementsAre(kWholeFrame, kWholeFrame, kPartFrame, kPartFrame));
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::no_answer));
}

// Two that only overlap: both are tried one by one, for the last time.
TEST_F(BusMergedRead, ItsPartsAreNotMergedAgain) {
  auto merging = settings();
  merging.merge = true;
  open(merging);
  submit(job_of(99, kRead, 2));
  advance(10ms);
  submit(job_of(0, "03 0000 0001"));
  submit(job_of(1, kPart));
  advance(10s);
  EXPECT_THAT(frames_, ElementsAre(testing::_, kWholeFrame, kPartFrame, "01 03 00 00 00 01 84 0A"));
}

TEST_F(BusMergedRead, WhoAskedForAllOfItIsRefusedAsItWas) {
  merge(0);
  advance(10ms);
  line("01 83 02 C0 F1");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(jobs_[1].transactions[0].response, modbus::Pdu::from(unhex("83 02")));
  advance(10ms);
  EXPECT_THAT(frames_, ElementsAre(kWholeFrame, kPartFrame));
}

TEST_F(BusMergedRead, ItsPartIsNotSentForAClientThatHasGone) {
  merge(0);
  advance(10ms);
  jobs_[2].abandoned = true;
  line("01 83 02 C0 F1");
  advance(10ms);
  EXPECT_THAT(frames_, ElementsAre(kWholeFrame));
  EXPECT_THAT(endings_, ElementsAre(Ending::cancelled, Ending::answered));
}

}  // namespace
}  // namespace mbgate::test

// SPDX-License-Identifier: Apache-2.0
// Writes before reads, bursts, weights, and who has to make room in a full queue.
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

class BusClasses : public Bus {
 protected:
  /// Lets everything that waits go; each is answered with an exception after 10 ms. Returns the
  /// functions that were transmitted.
  std::string served() {
    std::string functions;
    for (std::size_t at = 0; at < frames_.size(); ++at) {
      const auto frame = unhex(frames_[at]);
      functions += frame[1] == 3 ? 'r' : 'w';
      units_.push_back(frame[0]);
      advance(10ms);
      const auto pdu = modbus::Pdu::exception(frame[1], modbus::ExceptionCode::illegal_function);
      const auto answer = modbus::encode_rtu(frame[0], pdu);
      bus_->handle_bytes({answer.data(), answer.size()}, now_);
      drain();
      advance(5ms);
    }
    return functions;
  }
  std::vector<int> units_;
};

TEST_F(BusClasses, WritesOvertakeTheReadsOfOthersButNotTheirOwn) {
  open(settings());
  submit(job_of(9, kRead, 9));
  submit(job_of(0, kRead, 1));
  submit(job_of(1, kRead, 2));
  submit(job_of(1, "06 0000 0001", 2));
  submit(job_of(2, "06 0000 0001", 3));
  EXPECT_EQ(served(), "rwrrw");
  EXPECT_THAT(units_, ElementsAre(9, 3, 1, 2, 2));
}

TEST_F(BusClasses, AfterABurstOfWritesAReadGoes) {
  auto short_burst = settings();
  short_burst.burst = 2;
  open(short_burst);
  submit(job_of(9, kRead, 9));
  for (int times = 0; times < 5; ++times) {
    submit(job_of(0, "06 0000 0001", 1));
    submit(job_of(1, kRead, 2));
  }
  EXPECT_EQ(served(), "rwwrwwrwrrr");
}

TEST_F(BusClasses, AClientOfMoreWeightHasMoreTurns) {
  open(settings());
  submit(job_of(9, kRead, 9));
  for (int times = 0; times < 6; ++times) {
    bus::Job& heavy = job_of(0, kRead, 1);
    heavy.weight = 3;
    submit(heavy);
    submit(job_of(1, kRead, 2));
  }
  served();
  EXPECT_THAT(units_, ElementsAre(9, 1, 1, 1, 2, 1, 1, 1, 2, 2, 2, 2, 2));
}

TEST_F(BusClasses, ManyRequestsOfOneClientAddressDoNotOutweighOneOfAnother) {
  open(settings());
  submit(job_of(9, kRead, 9));
  for (int times = 0; times < 200; ++times) {
    submit(job_of(0, kRead, 1));
  }
  for (std::uint32_t source = 1; source < 32; ++source) {
    submit(job_of(source, kRead, static_cast<std::uint8_t>(100 + source)));
  }
  served();
  for (int at = 2; at < 33; ++at) {
    EXPECT_GT(units_[static_cast<std::size_t>(at)], 100) << at;
  }
}

TEST_F(BusClasses, AFullQueueLosesTheNewestReadOfWhoHasTheMostWaiting) {
  auto small = settings();
  small.queue = 4;
  open(small);
  submit(job_of(9, kRead, 9));
  submit(job_of(0, kRead, 1));
  submit(job_of(0, kRead, 2));
  submit(job_of(0, "06 0000 0001", 3));
  submit(job_of(1, kRead, 4));
  bus::Job& newcomer = job_of(2, "06 0000 0001", 5);
  submit(newcomer);
  EXPECT_TRUE(newcomer.is_waiting());
  EXPECT_THAT(endings_, ElementsAre(Ending::cancelled));
  EXPECT_FALSE(jobs_[2].is_waiting());
  EXPECT_EQ(bus_->counters().evicted, 1U);
  EXPECT_EQ(bus_->parts().waiting(), 4U);
}

TEST_F(BusClasses, WhereNoReadCanMakeRoomTheNewcomerIsRefused) {
  auto small = settings();
  small.queue = 2;
  open(small);
  submit(job_of(9, kRead, 9));
  submit(job_of(0, "06 0000 0001", 1));
  submit(job_of(0, "06 0000 0001", 2));
  EXPECT_FALSE(bus_->submit(job_of(1, kRead, 3), now_));
  EXPECT_EQ(bus_->counters().refused_full, 1U);
}

}  // namespace
}  // namespace mbgate::test

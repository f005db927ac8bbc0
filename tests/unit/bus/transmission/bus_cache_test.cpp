// SPDX-License-Identifier: Apache-2.0
// Reads that are answered from memory, and what empties it.
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

class BusCache : public Bus {
 protected:
  void open_with_cache(bus::Duration age = 50ms, unsigned retries = 0) {
    drive::Device device{"axis", {}, 1, settings().timing};
    device.cache = age;
    device.timing.retries = retries;
    open(settings(), {device});
  }
  void read() {
    submit(job(kRead));
    advance(10ms);
    line(kAnswer);
    advance(10ms);
  }
};

TEST_F(BusCache, ARepeatedReadIsAnsweredWithinItsAge) {
  open_with_cache();
  read();
  submit(job(kRead));
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
  EXPECT_EQ(jobs_[1].transactions[0].response, modbus::Pdu::from(unhex("03 02 12 34")));
  EXPECT_EQ(bus_->counters().cached_reads, 1U);
  submit(job("03 0000 0002"));
  EXPECT_THAT(frames_, SizeIs(2));
  advance(50ms);
  submit(job(kRead));
  EXPECT_THAT(endings_, SizeIs(2));
}

// What answers the repetition may be the late answer to the first try.
TEST_F(BusCache, TheAgeCountsFromTheFirstTry) {
  open_with_cache(150ms, 1);
  submit(job(kRead));
  advance(110ms);
  ASSERT_THAT(frames_, SizeIs(2));
  line(kAnswer);
  advance(10ms);
  submit(job(kRead));
  EXPECT_EQ(bus_->counters().cached_reads, 1U);
  advance(50ms);
  submit(job(kRead));
  EXPECT_EQ(bus_->counters().cached_reads, 1U);
}

TEST_F(BusCache, AWriteEmptiesItWhenAcceptedAndWhenEnded) {
  open_with_cache();
  read();
  submit(job("06 0000 0001"));
  bus::Job& meanwhile = job_of(1, kRead);
  submit(meanwhile);
  EXPECT_TRUE(meanwhile.is_waiting());
  advance(10ms);
  line("01 06 00 00 00 01 48 0A");
  advance(5ms);
  EXPECT_TRUE(meanwhile.sent.in_flight);
}

TEST_F(BusCache, ABroadcastEmptiesItToo) {
  open_with_cache();
  read();
  submit(job("06 0000 0001", 0));
  bus::Job& meanwhile = job_of(1, kRead);
  submit(meanwhile);
  EXPECT_TRUE(meanwhile.is_waiting());
}

TEST_F(BusCache, IsFilledAgainWhenTheWriteOrTheBroadcastHasEnded) {
  for (const auto written : {std::uint8_t{1}, std::uint8_t{0}}) {
    open_with_cache();
    submit(job("06 0000 0001", written));
    advance(10ms);
    line(written == 0 ? "" : "01 06 00 00 00 01 48 0A");
    advance(150ms);  // the turnaround delay
    read();
    submit(job(kRead));
    EXPECT_EQ(bus_->counters().cached_reads, 1U) << "address " << int{written};
  }
}

// The broadcast, of which the new device has seen the end alone, counts as none of its writes.
TEST_F(BusCache, OfADeviceThatIsAddedDuringABroadcastHoldsNothingFromBeforeALaterWrite) {
  open_with_cache();
  submit(job("06 0000 0001", 0));
  drive::Device added{"added", {}, 2, settings().timing};
  added.cache = 1s;
  update(settings(), {added});
  advance(150ms);
  submit(job(kRead, 2));
  submit(job("06 0000 0001", 2));
  line("02 03 02 12 34 F1 33");
  advance(10ms);
  ASSERT_THAT(frames_, SizeIs(3));
  bus::Job& meanwhile = job_of(1, kRead, 2);
  submit(meanwhile);
  EXPECT_TRUE(meanwhile.is_waiting());
}

TEST_F(BusCache, ATimeoutEmptiesIt) {
  open_with_cache();
  read();
  submit(job("03 0010 0001"));
  bus_->handle_deadline(now_ + 1s);
  drain();
  submit(job(kRead));
  EXPECT_EQ(bus_->counters().cached_reads, 0U);
}

TEST_F(BusCache, ReopeningEmptiesIt) {
  open_with_cache();
  read();
  bus_->handle_lost(now_);
  bus_->handle_opened(now_);
  drain();
  submit(job(kRead));
  EXPECT_EQ(bus_->counters().cached_reads, 0U);
}

// On a connection a stop may wait for the writes before it, and be answered before a read that was
// transmitted meanwhile.
TEST(ReadCache, DoesNotKeepWhatWasAskedWhileAWriteWaited) {
  drive::Transaction asked(1, *modbus::Request::parse(*modbus::Pdu::from(unhex(kRead))));
  asked.response = modbus::Pdu::from(unhex("03 02 12 34"));
  const Instant asked_at{1s};
  bus::ReadCache cache;
  cache.begin_write();
  const std::uint64_t ended = cache.writes_ended();
  cache.end_write();
  cache.put(asked, asked_at, ended);
  EXPECT_EQ(cache.find(asked, asked_at), nullptr);
  cache.put(asked, asked_at, cache.writes_ended());
  EXPECT_NE(cache.find(asked, asked_at), nullptr);
}

}  // namespace
}  // namespace mbgate::test

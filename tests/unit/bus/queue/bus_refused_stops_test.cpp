// SPDX-License-Identifier: Apache-2.0
// Stops that their drive answers with an exception.
#include <fmt/format.h>

#include "unit/bus/bus_rig.hpp"

namespace mbgate::test::bus_refused_stops_test {
namespace {

using Kind = bus::DeviceNotice::Kind;

constexpr auto kStop = "06 007C 00E1";
constexpr auto kStopFrame = "01 06 00 7C 00 E1 88 5A";
constexpr auto kBusy = "01 86 06 C2 62";
constexpr auto kAcknowledge = "01 86 05 82 63";

class BusRefusedStops : public Bus {
 protected:
  static drive::Device axis() {
    drive::Device device{"axis", {}, 1, settings().timing};
    device.profile.stops = {{.address = 0x007C, .value = 0x00E1}};
    return device;
  }
  [[nodiscard]] std::size_t stops_sent() const {
    return static_cast<std::size_t>(std::ranges::count(frames_, kStopFrame));
  }
};

TEST_F(BusRefusedStops, AreRepeatedNoSoonerThanStopWaitAndTold) {
  open(settings(), {axis()});
  submit(job(kStop));
  for (std::size_t tries = 1; tries <= 4; ++tries) {
    EXPECT_THAT(endings_, IsEmpty());
    advance(20ms);
    EXPECT_EQ(stops_sent(), tries);
    line(kBusy);
    advance(99ms);
    EXPECT_EQ(stops_sent(), tries);
  }
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));  // with the exception
  EXPECT_EQ(jobs_.front().transaction().response->bytes()[1], 0x06);
  EXPECT_THAT(notices_, ElementsAre(Kind::stop_refused));
  EXPECT_EQ(last_notice_.exception, 0x06);
  EXPECT_EQ(bus_->counters().stops_unanswered, 1U);
}

TEST_F(BusRefusedStops, AreRepeatedAfterAnyExceptionThatMayPass) {
  for (const auto* refusal : {kAcknowledge, kBusy, "01 86 0A C2 67", "01 86 0B 03 A7"}) {
    open(settings(), {axis()});
    frames_.clear();
    endings_.clear();
    submit(job(kStop));
    advance(10ms);
    line(refusal);
    advance(150ms);
    EXPECT_EQ(stops_sent(), 2U) << refusal;
    line(kStopFrame);
    EXPECT_THAT(endings_, ElementsAre(Ending::answered)) << refusal;
  }
  EXPECT_THAT(notices_, IsEmpty());
}

TEST_F(BusRefusedStops, GetAnyOtherExceptionAsTheirAnswer) {
  open(settings(), {axis()});
  submit(job(kStop));
  advance(10ms);
  line("01 86 04 43 A3");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  advance(1s);
  EXPECT_EQ(stops_sent(), 1U);
  EXPECT_THAT(notices_, ElementsAre(Kind::stop_refused));
}

TEST_F(BusRefusedStops, AreAcknowledgedByAnExceptionThatTheProfileCallsAnAcceptance) {
  drive::Device fda = axis();
  fda.profile.acceptances.set(0x05);
  open(settings(), {fda});
  submit(job(kStop));
  advance(10ms);
  line(kAcknowledge);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  advance(1s);
  EXPECT_EQ(stops_sent(), 1U);
  EXPECT_THAT(notices_, IsEmpty());
}

// Until then the drive is left alone.
TEST_F(BusRefusedStops, LetOthersHaveTheLineBetweenTheirTries) {
  open(settings(), {axis()});
  submit(job(kStop));
  advance(10ms);
  line(kBusy);
  submit(job_of(1, kRead, 1));
  submit(job_of(1, kRead, 2));
  advance(5ms);
  EXPECT_THAT(frames_, ElementsAre(kStopFrame, kOtherDevice));
  line("02 03 02 12 34 F1 33");
  advance(100ms);
  EXPECT_THAT(frames_, ElementsAre(kStopFrame, kOtherDevice, kStopFrame));
  advance(10ms);
  line(kStopFrame);
  advance(5ms);
  EXPECT_EQ(frames_.back(), kReadFrame);
}

// Two clients send a stop again as soon as it is refused.
TEST_F(BusRefusedStops, DoNotHaveTheLineForThemselves) {
  open(settings(), {axis()});
  submit(job_of(1, kStop));
  submit(job_of(2, "10 007C 0001 02 00E1"));
  submit(job_of(3, kRead, 2));
  for (int times = 0; times < 10 && frames_.back() != kOtherDevice; ++times) {
    advance(10ms);
    refuse(1, frames_.back().substr(3, 2) == "06" ? 6 : 16);
    submit(job_of(1 + times % 2, times % 2 == 0 ? kStop : "10 007C 0001 02 00E1"));
    advance(5ms);
  }
  EXPECT_THAT(frames_, testing::Contains(kOtherDevice));
}

TEST_F(BusRefusedStops, AreJoinedByStopsThatAreTheSame) {
  open(settings(), {axis()});
  submit(job(kStop));
  advance(10ms);
  line(kBusy);
  submit(job_of(1, kStop));
  advance(150ms);
  EXPECT_EQ(stops_sent(), 2U);
  line(kStopFrame);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
  advance(1s);
  EXPECT_EQ(stops_sent(), 2U);
}

TEST_F(BusRefusedStops, AreJoinedByNoMoreThanThereIsRoomFor) {
  open(settings(), {axis()});
  submit(job(kStop));
  advance(10ms);
  line(kBusy);
  for (std::size_t joins = 0; joins < bus::kRoomForStops; ++joins) {
    submit(job_of(1, kStop));
  }
  EXPECT_FALSE(bus_->submit(job_of(1, kStop), now_));
  submit(job_of(2, kStop));  // another client's always has room
  advance(150ms);
  line(kStopFrame);
  EXPECT_EQ(std::ranges::count(endings_, Ending::answered), 2 + bus::kRoomForStops);
}

TEST_F(BusRefusedStops, HaveRoomBesideManyDifferentOnesToAnotherDeviceOrOfAnotherClient) {
  std::vector<drive::Device> devices{axis(), axis()};
  devices[1].address = 2;
  devices[0].profile.stops =
      devices[1].profile.stops = {{.address = 0x007C, .mask = 0xF000, .value = 0x5000}};
  open(settings(), devices);
  const auto stop = [](std::size_t word) { return fmt::format("06 007C {:04X}", 0x5000 + word); };
  for (std::size_t word = 0; word <= bus::kRoomForStops; ++word) {
    EXPECT_TRUE(bus_->submit(job(stop(word)), now_));
    drain();
  }
  EXPECT_FALSE(bus_->submit(job(stop(bus::kRoomForStops + 1)), now_));
  EXPECT_TRUE(bus_->submit(job(stop(0), 2), now_));
  EXPECT_TRUE(bus_->submit(job_of(1, stop(bus::kRoomForStops + 1)), now_));
}

TEST_F(BusRefusedStops, KeepTheirPlacesWhileTheyRest) {
  drive::Device device = axis();
  device.profile.stops = {{.address = 0x007C, .mask = 0xF000, .value = 0x5000}};
  open(settings(), {device});
  const auto stop = [](std::size_t word) { return fmt::format("06 007C {:04X}", 0x5000 + word); };
  submit(job(stop(0)));
  advance(10ms);
  line(kBusy);
  for (std::size_t word = 1; word < bus::kRoomForStops; ++word) {
    submit(job(stop(word)));
  }
  EXPECT_FALSE(bus_->submit(job(stop(bus::kRoomForStops)), now_));
}

TEST_F(BusRefusedStops, AreSentOnTheNextLineIfTheirsIsLostWhileTheyRest) {
  open(settings(), {axis()});
  submit(job(kStop));
  advance(10ms);
  line(kBusy);
  bus_->handle_lost(now_);
  drain();
  EXPECT_THAT(endings_, IsEmpty());
  bus_->handle_opened(now_);
  advance(200ms);
  EXPECT_EQ(stops_sent(), 2U);
}

}  // namespace
}  // namespace mbgate::test::bus_refused_stops_test

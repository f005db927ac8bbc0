// SPDX-License-Identifier: Apache-2.0
// Every frame of the RS-485 stepper's manual, through the machine, with its profile: the drive
// speaks low word first, and the client sees what it wants to see.
#include <gmock/gmock.h>

#include "drives/drive_bench.hpp"
#include "drives/simulated_maps.hpp"
#include "sim/drives/stepper_drive.hpp"

namespace mbgate::test {
namespace {

constexpr auto* kProfile = "rs485-stepper";

/// Writes of 0x0009 (baud rate) and 0x0066 (address).
constexpr std::array kCommunication{371U, 1078U};
/// The restart has no answer (line 2020).
constexpr unsigned kRestart = 2018;
constexpr unsigned kSave = 2060;

std::string at(unsigned line) { return "rs485-stepper:" + std::to_string(line); }

/// The versions (line 242): their bytes are text, not a number.
bool is_string(std::uint32_t address) { return address < 0x0004; }

/// The data of a frame, from `offset` on, are the registers from `first` on; the frame with the
/// words of each value the other way round. Its CRC is not made new.
manuals::ByteList exchanged(manuals::ByteList frame, std::size_t offset, std::uint32_t first) {
  for (std::size_t i = offset; i + 5 < frame.size(); i += 2) {
    const auto address = static_cast<std::uint32_t>(first + (i - offset) / 2);
    if (place_of(sim::stepper_registers(), address).part == Part::first_half &&
        !is_string(address)) {
      std::swap_ranges(frame.begin() + static_cast<std::ptrdiff_t>(i),
                       frame.begin() + static_cast<std::ptrdiff_t>(i) + 2,
                       frame.begin() + static_cast<std::ptrdiff_t>(i) + 2);
    }
  }
  return frame;
}

/// The printed example as a client sees it that wants the high word first.
Example seen_big(Example example) {
  const auto request = request_of(example.rtu_request);
  const std::uint16_t first = range_of(request).first;
  if (request.function() == 0x10) {
    example.tcp_request = tcp_of(exchanged(unhex(example.rtu_request), 7, first));
  } else if (request.function() == 0x03) {
    example.tcp_response = tcp_of(exchanged(unhex(example.rtu_response), 3, first));
  }
  return example;
}

/// All but the restart; those that print no response are answered by a simulated drive.
std::vector<Example> printed() {
  std::vector<Example> examples;
  sim::StepperDrive drive;
  for (Example example : printed_frames()) {
    if (example.where.starts_with(kProfile) && example.where != at(kRestart)) {
      if (!prints_response(example)) {
        answer_by(drive, example);
      }
      examples.push_back(example);
    }
  }
  return examples;
}

drive::Device stepper() {
  drive::Device device = device_with(kProfile, std::nullopt);
  device.allow_reconfigure = true;
  return device;
}

TEST(StepperFrames, AreAllHere) {
  const auto frames = manuals::load_rtu();
  EXPECT_EQ(std::ranges::count(frames, kProfile, &manuals::Frame::manual), 279);
  EXPECT_EQ(printed().size(), 143U);  // requests, the restart is the 144th
}

TEST(StepperFrames, LeaveAsPrintedForAClientThatSeesTheHighWordFirst) {
  MachineRig rig(route_to(stepper(), WordOrder::big));
  rig.connect(1);
  std::size_t different = 0;
  for (const Example& example : printed()) {
    const Example seen = seen_big(example);
    different += seen.tcp_request != example.tcp_request ? 1U : 0U;
    different += seen.tcp_response != example.tcp_response ? 1U : 0U;
    expect_exchange(rig, 1, seen);
  }
  EXPECT_EQ(different, 23U);  // 17 writes and 6 responses hold values
  EXPECT_EQ(next_adu(rig, 1, 1s), "");
  EXPECT_EQ(next_frame(rig, 1s), "");
}

TEST(StepperFrames, PassAsTheyAreForAClientThatSeesTheDrivesOwnOrder) {
  for (const Seen seen : {Seen(WordOrder::little), Seen()}) {
    MachineRig rig(route_to(stepper(), seen));
    rig.connect(1);
    for (const Example& example : printed()) {
      expect_exchange(rig, 1, example);
    }
  }
}

// So none needs the partner's address, and none is refused because it cuts a value that starts
// motion.
TEST(StepperFrames, HoldOnlyWholeValues) {
  for (const Example& example : printed()) {
    EXPECT_FALSE(cuts_value(sim::stepper_registers(), range_of(request_of(example.rtu_request))))
        << example.where;
  }
}

// 2128, the position 10000, by its numbers.
TEST(StepperFrames, AMoveTo10000IsOneToTheClientToo) {
  const Example example = seen_big(example_at(printed(), at(2128)));
  EXPECT_EQ(example.tcp_request, "00 00 00 00 00 0B 01 10 00 D0 00 02 04 00 00 27 10");
  EXPECT_EQ(example.rtu_request, "01 10 00 D0 00 02 04 27 10 00 00 F5 82");
}

TEST(StepperFrames, ThatChangeTheCommunicationAreRefusedUnlessAllowed) {
  MachineRig rig(route_to(device_with(kProfile, std::nullopt), WordOrder::big));
  rig.connect(1);
  for (const unsigned line : kCommunication) {
    expect_refusal(rig, 1, example_at(printed(), at(line)), 0x01);
  }
}

// No answer comes (line 2020): the gateway gives it after the turnaround delay.
TEST(StepperFrames, OfTheRestartIsAnsweredByTheGateway) {
  MachineRig rig(route_to(stepper(), WordOrder::big));
  rig.connect(1);
  const Example restart = example_at(printed_frames(), at(kRestart));
  rig.receive(1, restart.tcp_request);
  EXPECT_EQ(next_frame(rig), restart.rtu_request);
  EXPECT_EQ(next_adu(rig, 1, 150ms), restart.tcp_request);
  EXPECT_EQ(next_frame(rig, 1s), "");
}

// Saving takes longer than other writes (line 2053).
TEST(StepperFrames, OfTheSaveMayTakeLongToBeAnswered) {
  MachineRig rig(route_to(stepper(), WordOrder::big));
  rig.connect(1);
  const Example save = example_at(printed(), at(kSave));
  rig.receive(1, save.tcp_request);
  EXPECT_EQ(next_frame(rig), save.rtu_request);
  rig.advance(1500ms);
  EXPECT_TRUE(rig.sent[1].empty());
  rig.line(save.rtu_response);
  EXPECT_EQ(next_adu(rig, 1), save.tcp_response);
}

}  // namespace
}  // namespace mbgate::test

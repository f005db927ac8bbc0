// SPDX-License-Identifier: Apache-2.0
// Every worked frame of the manuals of the Autonics AiC and the HIGEN FDA6000, through the machine,
// with their profiles.
#include "drives/drive_bench.hpp"

namespace mbgate::test {
namespace {

constexpr std::uint8_t kAicAddress = 17;
constexpr std::uint8_t kFdaAddress = 2;

/// The AiC's manual prints no CRC.
std::vector<Example> aic_examples() {
  const auto frames = manuals::load_without_crc();
  std::vector<Example> examples;
  for (std::size_t i = 0; i + 1 < frames.size(); i += 2) {
    const auto response = unhex(rtu_of(frames[i + 1].bytes));
    examples.push_back(example_of(frames[i].where(), unhex(rtu_of(frames[i].bytes)), &response));
    EXPECT_EQ(frames[i + 1].answers, frames[i].line);
  }
  return examples;
}

drive::Device aic() { return device_with("autonics-aic", std::nullopt, kAicAddress); }

TEST(AicFrames, LeaveAsPrintedWhateverTheClientWantsToSee) {
  const auto examples = aic_examples();
  EXPECT_EQ(examples.size(), 8U);
  for (const Seen seen : {Seen(WordOrder::big), Seen(WordOrder::little), Seen()}) {
    MachineRig rig(route_to(aic(), seen));
    rig.connect(1);
    for (const Example& example : examples) {
      expect_exchange(rig, 1, example);
    }
  }
}

// The manual asks for it (lines 634-637); the client gets the answer to its own request.
TEST(AicFrames, OfFunction16BecomeARunOf06WhereTheUserWantsIt) {
  drive::Device device = aic();
  device.write_function = 6;
  MachineRig rig(route_to(device, WordOrder::big));
  rig.connect(1);
  const Example example = example_at(aic_examples(), "autonics-aic:625");
  rig.receive(1, example.tcp_request);
  for (const auto* frame : {"11 06 00 00 00 0A", "11 06 00 01 00 0A"}) {
    const std::string single = rtu_of(unhex(frame));
    ASSERT_EQ(next_frame(rig), single);
    EXPECT_TRUE(rig.sent[1].empty());
    rig.advance(20ms);
    rig.line(single);
  }
  EXPECT_EQ(next_adu(rig, 1), example.tcp_response);
}

std::vector<Example> fda_examples() {
  std::vector<Example> examples = printed_frames();
  std::erase_if(examples,
                [](const Example& example) { return !example.where.starts_with("higen-fda6000"); });
  return examples;
}

drive::Device fda6000() { return device_with("higen-fda6000", std::nullopt, kFdaAddress); }

constexpr auto* kOfFunction01 = "higen-fda6000:346";

// The drive has no function 01; the manual asks for it to show an exception.
TEST(Fda6000Frames, LeaveAsPrintedOnARouteThatNamesItsFunctions) {
  const auto examples = fda_examples();
  EXPECT_EQ(examples.size(), 5U);
  for (const Seen seen : {Seen(WordOrder::big), Seen(WordOrder::little), Seen()}) {
    Settings settings = route_to(fda6000(), seen);
    settings.routes[0].functions_named = true;
    MachineRig rig(settings);
    rig.connect(1);
    for (const Example& example : examples) {
      expect_exchange(rig, 1, example);
    }
  }
}

TEST(Fda6000Frames, LeaveAsPrintedButForAFunctionThatTheDriveDoesNotHave) {
  MachineRig rig(route_to(fda6000(), std::nullopt));
  rig.connect(1);
  for (const Example& example : fda_examples()) {
    if (example.where == kOfFunction01) {
      expect_refusal(rig, 1, example, 0x01);
    } else {
      expect_exchange(rig, 1, example);
    }
  }
}

}  // namespace
}  // namespace mbgate::test

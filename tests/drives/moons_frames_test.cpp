// SPDX-License-Identifier: Apache-2.0
// Every worked frame of the MOONS' manual, through the machine, with drives of PR=5 and of PR=133:
// the same TCP traffic for both, and on the line the frames that the manual prints for each.
#include <gmock/gmock.h>

#include "drives/drive_bench.hpp"
#include "drives/simulated_maps.hpp"
#include "sim/drives/moons_drive.hpp"

namespace mbgate::test::moons_frames_test {
namespace {

using sim::MoonsDrive;

/// One request as it is printed for either order, by the lines of its RTU frames.
struct Printed {
  unsigned big;
  unsigned little;
  MoonsSeries home = MoonsSeries::st;  ///< whose registers it means
};

constexpr std::array kPrinted{
    // 5.1 to 5.3: reading, writing one register
    Printed{242, 242}, Printed{261, 261}, Printed{285, 285}, Printed{306, 306},
    // 7.1: three SHORTs and a LONG; FL, FP, SK; the LONG read
    Printed{467, 481}, Printed{495, 495}, Printed{503, 503}, Printed{511, 511}, Printed{519, 519},
    // 7.2
    Printed{549, 549}, Printed{563, 563}, Printed{577, 577},
    // 7.3: ten registers that only an M3 has, FH, another one of them
    Printed{607, 621, MoonsSeries::m3}, Printed{635, 635}, Printed{653, 667, MoonsSeries::m3},
    // 7.4.4: the two parts, and what is printed in the first one only
    Printed{858, 736}, Printed{872, 750}, Printed{880, 758}, Printed{894, 772}, Printed{786, 786},
    Printed{794, 794}, Printed{802, 802}, Printed{810, 810}, Printed{818, 818}, Printed{826, 826},
    Printed{840, 840}, Printed{848, 848}};

/// 5.3 writes a LONG with the high word first, twice, and prints no twin of it.
constexpr std::array kWithoutTwin{333U, 354U};
constexpr auto* kTwin = "0A 10 00 1E 00 02 04 75 30 00 00";

/// The high register of a value alone, with the same bytes for both orders: one of each two must
/// mean something else than it says.
constexpr std::array kHalfValues{764U, 778U, 886U, 900U};

std::string at(unsigned line) { return "moons-drives:" + std::to_string(line); }

/// Frames that are printed without a TCP ADU come with the one that fits.
std::vector<Example> all_printed() {
  std::vector<Example> examples = printed_pairs();
  for (const Example& frame : printed_frames()) {
    if (frame.where.starts_with("moons-drives") &&
        std::ranges::find(examples, frame.where, &Example::where) == examples.end()) {
      examples.push_back(frame);
    }
  }
  return examples;
}

/// One transaction as it is with each word order.
struct Worked {
  Example big;
  Example little;
  [[nodiscard]] const Example& in(WordOrder order) const {
    return order == WordOrder::big ? big : little;
  }
};

/// The pair of drives that answers where the manual prints no response.
struct Twins {
  explicit Twins(MoonsSeries series)
      : big(series, WordOrder::big), little(series, WordOrder::little) {
    if (series != MoonsSeries::m3) {
      for (MoonsDrive* drive : {&big, &little}) {
        drive->registers().set(0x003E, 11);  // what the program of 7.4.1 has set
        drive->registers().set(0x0040, 12);
      }
    }
  }
  MoonsDrive big;
  MoonsDrive little;
};

/// Has the series the same kind of registers there as the one that the example is for?
bool has_registers(MoonsSeries series, MoonsSeries home, const Example& example) {
  const auto range = range_of(request_of(example.rtu_request));
  for (std::uint32_t address = range.first; address < drive::end_of(range); ++address) {
    if (place_of(sim::moons_registers(series), address).part !=
        place_of(sim::moons_registers(home), address).part) {
      return false;
    }
  }
  return true;
}

/// All examples that mean registers of the series.
std::vector<Worked> worked_examples(MoonsSeries series) {
  const auto printed = all_printed();
  Twins twins(series);
  std::vector<Worked> examples;
  const auto add = [&](Worked worked, MoonsSeries home) {
    if (has_registers(series, home, worked.big)) {
      answer_by(twins.big, worked.big);
      answer_by(twins.little, worked.little);
      examples.push_back(worked);
    }
  };
  for (const unsigned line : kWithoutTwin) {
    const Example big = example_at(printed, at(line));
    Example little = example_of(at(line), unhex(rtu_of(unhex(kTwin))), nullptr);
    little.rtu_response = big.rtu_response;
    little.tcp_response = big.tcp_response;
    add({big, little}, MoonsSeries::st);
  }
  for (const Printed& line : kPrinted) {
    add({example_at(printed, at(line.big)), example_at(printed, at(line.little))}, line.home);
  }
  return examples;
}

std::vector<drive::Device> drives(const std::string& profile, WordOrder order) {
  return {device_with(profile, order, 1), device_with(profile, order, 10),
          device_with(profile, order, 11)};
}

TEST(MoonsFrames, AreAllHere) {
  std::vector<std::string> named;
  for (const Printed& line : kPrinted) {
    named.push_back(at(line.big));
    if (line.little != line.big) {
      named.push_back(at(line.little));
    }
  }
  std::ranges::transform(kWithoutTwin, std::back_inserter(named), at);
  std::ranges::transform(kHalfValues, std::back_inserter(named), at);
  std::vector<std::string> printed;
  std::ranges::transform(all_printed(), std::back_inserter(printed), &Example::where);
  EXPECT_EQ(printed.size(), 40U);
  EXPECT_THAT(named, testing::UnorderedElementsAreArray(printed));
}

/// A series and how many of the examples mean its registers.
struct Covered {
  Series series;
  std::size_t examples;
};

class MoonsFrames : public testing::TestWithParam<Covered> {
 protected:
  /// The client's order need not be the drive's.
  static void replay(const std::vector<Worked>& examples, WordOrder spoken, WordOrder seen) {
    MachineRig rig(routes_to(drives(GetParam().series.profile, spoken), seen));
    rig.connect(1);
    for (const Worked& worked : examples) {
      expect_exchange(rig, 1,
                      {worked.big.where, worked.in(seen).tcp_request, worked.in(spoken).rtu_request,
                       worked.in(spoken).rtu_response, worked.in(seen).tcp_response});
    }
    EXPECT_EQ(next_adu(rig, 1, 1s), "");
    EXPECT_EQ(next_frame(rig, 1s), "");
  }
};

TEST_P(MoonsFrames, OfBothOrdersAreOneTcpTraffic) {
  const auto examples = worked_examples(GetParam().series.series);
  EXPECT_EQ(examples.size(), GetParam().examples);
  replay(examples, WordOrder::big, WordOrder::big);
  replay(examples, WordOrder::little, WordOrder::big);
}

TEST_P(MoonsFrames, OfBothOrdersAreOneTcpTrafficForALittleEndianClientToo) {
  const auto examples = worked_examples(GetParam().series.series);
  replay(examples, WordOrder::big, WordOrder::little);
  replay(examples, WordOrder::little, WordOrder::little);
}

std::string case_name(const testing::TestParamInfo<Covered>& info) {
  return std::string(info.param.series.profile).substr(6);
}

INSTANTIATE_TEST_SUITE_P(Series, MoonsFrames,
                         testing::Values(Covered{kSeries[0], 27}, Covered{kSeries[1], 27},
                                         Covered{kSeries[2], 27}, Covered{kSeries[3], 27},
                                         Covered{kSeries[4], 27}, Covered{kSeries[5], 12},
                                         Covered{kSeries[6], 27}, Covered{kSeries[7], 27}),
                         case_name);

TEST(MoonsHalfValues, LeaveAsPrintedOnARouteWithoutWordOrder) {
  for (const WordOrder order : {WordOrder::big, WordOrder::little}) {
    MachineRig rig(routes_to(drives("moons-st", order), std::nullopt));
    rig.connect(1);
    for (const unsigned line : kHalfValues) {
      expect_exchange(rig, 1, example_at(all_printed(), at(line)));
    }
  }
}

TEST(MoonsHalfValues, GoToThePartnerWhereTheOrderDiffers) {
  MachineRig rig(routes_to(drives("moons-st", WordOrder::little), WordOrder::big));
  rig.connect(1);
  for (const unsigned line : kHalfValues) {
    Example example = example_at(all_printed(), at(line));
    const auto frame = unhex(example.rtu_request);
    example.rtu_request = rtu_of(manuals::ByteList{1, 6, 0x00, 0x3D, frame[4], frame[5]});
    example.rtu_response = example.rtu_request;
    example.tcp_response = example.tcp_request;
    expect_exchange(rig, 1, example);
  }
}

/// EP and SP with a position of 200000 in 40126 and 40127; no frame of them is printed.
std::vector<Example> position_opcodes() {
  std::vector<Example> examples;
  for (const auto* request :
       {"01 10 00 7C 00 03 06 00 98 00 03 0D 40", "01 10 00 7C 00 03 06 00 A5 00 03 0D 40",
        "01 06 00 7C 00 98", "01 06 00 7C 00 A5"}) {
    examples.push_back(example_of(request, unhex(rtu_of(unhex(request))), nullptr));
  }
  return examples;
}

TEST(MoonsPositionOpcodes, LeaveAsTheyComeOnARouteWithoutWordOrder) {
  for (const Series& series : kSeries) {
    for (const WordOrder order : {WordOrder::big, WordOrder::little}) {
      MachineRig rig(routes_to(drives(series.profile, order), std::nullopt));
      rig.connect(1);
      for (const Example& example : position_opcodes()) {
        expect_exchange(rig, 1, example);
      }
    }
  }
}

TEST(MoonsPositionOpcodes, AreRefusedWhereWordsWouldBeExchanged) {
  for (const Series& series : kSeries) {
    MachineRig rig(routes_to(drives(series.profile, WordOrder::little), WordOrder::big));
    rig.connect(1);
    for (const Example& example : position_opcodes()) {
      expect_refusal(rig, 1, example, 0x03);
    }
  }
}

// 7.1, spelled out: 600, 600, 240, and 200000.
TEST(MoonsDrives, OnlyTheLongIsExchangedInAWriteOf40028To40032ForPr133) {
  const Example big{"moons-drives:467",
                    "00 00 00 00 00 11 01 10 00 1B 00 05 0A 02 58 02 58 00 F0 00 03 0D 40",
                    "01 10 00 1B 00 05 0A 02 58 02 58 00 F0 00 03 0D 40 CD 83",
                    "01 10 00 1B 00 05 70 0D", "00 00 00 00 00 06 01 10 00 1B 00 05"};
  Example little = big;
  little.rtu_request = "01 10 00 1B 00 05 0A 02 58 02 58 00 F0 0D 40 00 03 7B 9A";
  MachineRig with_pr5(routes_to(drives("moons-st", WordOrder::big), WordOrder::big));
  with_pr5.connect(1);
  expect_exchange(with_pr5, 1, big);
  MachineRig with_pr133(routes_to(drives("moons-st", WordOrder::little), WordOrder::big));
  with_pr133.connect(1);
  expect_exchange(with_pr133, 1, little);
}

}  // namespace
}  // namespace mbgate::test::moons_frames_test

// SPDX-License-Identifier: Apache-2.0
// What belongs to no frame completes none.
#include "soak/overheard.hpp"

#include <gtest/gtest.h>

#include "soak/specification.hpp"

namespace mbgate::soak {
namespace {

constexpr std::uint8_t kAddress = 15;

void hear(Overheard& line, const spec::Octets& bytes) {
  for (const std::uint8_t byte : bytes) {
    line.add(byte);
  }
}

TEST(Overheard, AStrayByteCompletesNoFrame) {
  Overheard line;
  hear(line, {0xFF, kAddress, 0x07, 0x45, 0x82});
  EXPECT_NE(line.add_stray(0x00, kAddress), 0x00);  // status 45
}

TEST(Overheard, NorDoesTheOneBehindIt) {
  Overheard line;
  hear(line, spec::rtu_frame(kAddress, spec::Octets{0x11}));
  EXPECT_NE(line.add_stray(0x00, kAddress), 0x00);
  EXPECT_EQ(line.add_stray(0x00, kAddress), 0x00);
}

TEST(Overheard, OfNobodyWhoWasAskedOrBehindWhatIsOverItIsWhatItWas) {
  Overheard line;
  hear(line, {kAddress, 0x07, 0x45, 0x82});
  EXPECT_EQ(line.add_stray(0x00, kAddress + 1), 0x00);
  line.forget();
  EXPECT_EQ(line.add_stray(0x00, kAddress), 0x00);
}

TEST(Overheard, AFrameIsDamagedThatCompletesAnotherButForItself) {
  const spec::Octets frame = spec::rtu_frame(kAddress, spec::Octets{0x11});
  Overheard line;
  hear(line, {frame[0], frame[1], frame[2]});
  Overheard same = line;
  EXPECT_EQ(line.add(frame[3], kAddress, frame.size()), frame[3]);
  EXPECT_NE(same.add(frame[3], kAddress, 2), frame[3]);
}

}  // namespace
}  // namespace mbgate::soak

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

// The echo of a read of unit 1 ends in 01; what comes behind it had its own 01 before it.
TEST(Overheard, WhatWasCutIsNoFrameFromAByteOfAnotherOn) {
  const spec::Octets frame = spec::rtu_frame(1, spec::Octets{0x03, 0x02, 0x12, 0x34});
  Overheard line;
  line.add(frame[0]);
  const std::uint64_t from = line.count() - 1;
  hear(line, {0x01, 0x03, 0x00, 0x38, 0x00, 0x04, 0xC4, 0x01});
  hear(line, {frame.begin() + 1, frame.end() - 1});
  EXPECT_NE(line.count() + 1 - from, frame.size());
  EXPECT_NE(line.add(frame.back(), 1, 0), frame.back());
}

}  // namespace
}  // namespace mbgate::soak

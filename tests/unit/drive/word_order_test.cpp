// SPDX-License-Identifier: Apache-2.0
// Values as the manuals print them, in both orders.
#include <gtest/gtest.h>

#include <algorithm>

#include "drive/values.hpp"
#include "manuals/vectors.hpp"
#include "modbus/bytes.hpp"

namespace mbgate::drive {
namespace {

using enum WordOrder;

constexpr std::uint32_t two_s_complement(std::int32_t value) {
  return static_cast<std::uint32_t>(value);
}

struct Sample {
  std::uint32_t value;
  RegisterPair big_pair;
};

constexpr std::array kSamples{
    Sample{200000, {0x0003, 0x0D40}},                     // MOONS', position
    Sample{two_s_complement(-200000), {0xFFFC, 0xF2C0}},  // MOONS', position
    Sample{30000, {0x0000, 0x7530}},                      // MOONS' position, stepper speed
    Sample{10000, {0x0000, 0x2710}},                      // stepper, position
    Sample{two_s_complement(-10000), {0xFFFF, 0xD8F0}},   // stepper, pulses
    Sample{0, {0, 0}},
    Sample{0xFFFFFFFF, {0xFFFF, 0xFFFF}},
};

TEST(WordOrder, BigHasTheHighWordFirst) {
  for (const Sample& sample : kSamples) {
    EXPECT_EQ(to_registers(sample.value, big), sample.big_pair) << sample.value;
    EXPECT_EQ(from_registers(sample.big_pair, big), sample.value);
  }
}

TEST(WordOrder, LittleHasTheLowWordFirst) {
  for (const Sample& sample : kSamples) {
    const RegisterPair little_pair{sample.big_pair[1], sample.big_pair[0]};
    EXPECT_EQ(to_registers(sample.value, little), little_pair) << sample.value;
    EXPECT_EQ(from_registers(little_pair, little), sample.value);
  }
}

TEST(WordOrder, BytesWithinARegisterAreNeverExchanged) {
  EXPECT_EQ(to_registers(0x12345678, big), (RegisterPair{0x1234, 0x5678}));
  EXPECT_EQ(to_registers(0x12345678, little), (RegisterPair{0x5678, 0x1234}));
}

/// The data of a printed write of `function` 16, from its byte count on, as values.
std::vector<std::uint32_t> values_of(const manuals::ByteList& rtu, WordOrder order) {
  std::vector<std::uint32_t> values;
  for (std::size_t at = 7; at + 4 <= rtu.size() - 2; at += 4) {
    values.push_back(
        from_registers({modbus::load_be16(rtu, at), modbus::load_be16(rtu, at + 2)}, order));
  }
  return values;
}

// The MOONS' manual writes the same five values with PR=133 (line 750) and with PR=5 (line 872).
TEST(WordOrder, BothPrintedFormsOfFiveValuesMeanTheSame) {
  const std::vector<std::uint32_t> expected{600, 600, 240, 200000, two_s_complement(-200000)};
  const auto pairs = manuals::load_pairs();
  const auto little_pair = std::ranges::find(pairs, 750U, &manuals::Pair::line);
  const auto big_pair = std::ranges::find(pairs, 872U, &manuals::Pair::line);
  ASSERT_NE(little_pair, pairs.end());
  ASSERT_NE(big_pair, pairs.end());
  EXPECT_EQ(values_of(little_pair->rtu, little), expected);
  EXPECT_EQ(values_of(big_pair->rtu, big), expected);
}

// The stepper's position 10000 (line 1966) is written low word first: 27 10 00 00.
TEST(WordOrder, StepperWritesTheLowWordFirst) {
  const auto frames = manuals::load_rtu();
  const auto frame = std::ranges::find_if(frames, [](const manuals::Frame& candidate) {
    return candidate.manual == "rs485-stepper" && candidate.line == 1966;
  });
  ASSERT_NE(frame, frames.end());
  EXPECT_EQ(values_of(frame->bytes, little), std::vector<std::uint32_t>{10000});
}

}  // namespace
}  // namespace mbgate::drive

// SPDX-License-Identifier: Apache-2.0
#include "ctl/serial/heard.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace mbgate::ctl {
namespace {

using Octets = std::vector<std::uint8_t>;

/// Unit 5, function 03, register 0, count 1.
const SentRead& sent_read() {
  static const SentRead kSent(5, {modbus::Table::holding_registers, 0, 1});
  return kSent;
}

Octets frame_of(std::uint8_t unit, const Octets& pdu) {
  const auto frame = modbus::encode_rtu(unit, *modbus::Pdu::from(pdu));
  return {frame.begin(), frame.end()};
}

Octets joined(const std::vector<Octets>& parts) {
  Octets all;
  for (const auto& part : parts) {
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

Octets echo() { return {sent_read().frame().begin(), sent_read().frame().end()}; }

const Octets kData{0x03, 0x02, 0x12, 0x34};

TEST(SentRead, IsAReadWithItsCrc) {
  EXPECT_EQ(echo(), (Octets{0x05, 0x03, 0x00, 0x00, 0x00, 0x01, 0x85, 0x8E}));
}

TEST(SentRead, TakesDataAndExceptionsForAnAnswer) {
  for (const auto& pdu : {kData, Octets{0x83, 0x02}}) {
    const auto heard = sent_read().understand(frame_of(5, pdu));
    EXPECT_EQ(heard.kind, HeardKind::answer);
    EXPECT_EQ(heard.response, modbus::Pdu::from(pdu));
  }
}

TEST(SentRead, FindsTheAnswerBehindAnEchoAndAmongOtherBytes) {
  const auto answer = frame_of(5, kData);
  EXPECT_TRUE(sent_read().answer_in(joined({echo(), answer})));
  EXPECT_TRUE(sent_read().answer_in(joined({{0x00}, answer})));
  EXPECT_TRUE(sent_read().answer_in(joined({echo(), {0xFF}, answer, {0x00}})));
  EXPECT_TRUE(sent_read().answer_in(joined({frame_of(4, kData), answer})));
}

TEST(SentRead, WaitsForTheWholeAnswer) {
  const auto answer = frame_of(5, kData);
  for (std::size_t size = 0; size < answer.size(); ++size) {
    EXPECT_FALSE(sent_read().answer_in(modbus::Bytes(answer).first(size))) << size;
  }
}

TEST(SentRead, HearsNothingInItsOwnEcho) {
  const auto heard = sent_read().understand(echo());
  EXPECT_EQ(heard.kind, HeardKind::silence);
  EXPECT_EQ(heard.bytes, 0U);
  EXPECT_EQ(sent_read().understand({}).kind, HeardKind::silence);
}

TEST(SentRead, KnowsItsEchoBehindOtherBytes) {
  const auto behind_a_glitch = joined({{0xFF}, echo()});
  EXPECT_EQ(sent_read().echo_in(behind_a_glitch), 1U);
  EXPECT_EQ(sent_read().understand(behind_a_glitch).kind, HeardKind::silence);
  EXPECT_EQ(sent_read().understand(behind_a_glitch).bytes, 0U);
  const auto heard = sent_read().understand(joined({{0xFF}, echo(), frame_of(5, kData)}));
  EXPECT_EQ(heard.kind, HeardKind::answer);
  EXPECT_EQ(heard.bytes, 7U);
  EXPECT_EQ(sent_read().echo_in(frame_of(5, kData)), std::nullopt);
  EXPECT_EQ(sent_read().echo_in({}), std::nullopt);
}

TEST(SentRead, NamesTheUnitOfAnotherFrame) {
  const auto heard = sent_read().understand(joined({echo(), frame_of(4, kData)}));
  EXPECT_EQ(heard.kind, HeardKind::other_frame);
  EXPECT_EQ(heard.unit, 4);
  EXPECT_EQ(heard.bytes, 7U);
  // An answer of this unit, but not to this read.
  const auto late = sent_read().understand(frame_of(5, {0x03, 0x04, 0, 1, 0, 2}));
  EXPECT_EQ(late.kind, HeardKind::other_frame);
  EXPECT_EQ(late.unit, 5);
}

TEST(SentRead, TellsABadCrcFromNoise) {
  auto damaged = frame_of(5, kData);
  damaged.back() ^= 1U;
  EXPECT_EQ(sent_read().understand(damaged).kind, HeardKind::bad_crc);
  EXPECT_EQ(sent_read().understand(damaged).bytes, 7U);
  auto refusal = frame_of(5, {0x83, 0x02});
  refusal.back() ^= 1U;
  EXPECT_EQ(sent_read().understand(refusal).kind, HeardKind::bad_crc);
  EXPECT_EQ(sent_read().understand(Octets{0xFE}).kind, HeardKind::noise);
  EXPECT_EQ(sent_read().understand(Octets{0xFE, 1, 2, 3, 4, 5}).kind, HeardKind::noise);
}

}  // namespace
}  // namespace mbgate::ctl

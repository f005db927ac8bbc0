// SPDX-License-Identifier: Apache-2.0
// Every frame that the drive manuals print goes through the alphabet: bytes that nobody here made
// up.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "manuals/vectors.hpp"
#include "modbus/frames.hpp"
#include "modbus/mbap.hpp"
#include "modbus/response.hpp"
#include "unit/modbus/bytes_of.hpp"

namespace mbgate::modbus {
namespace {

using manuals::Direction;
using ::testing::ElementsAreArray;

/// The parsed request of a PDU that a manual prints.
Request request_of(const Pdu& pdu, const std::string& where) {
  const auto request = Request::parse(pdu);
  if (!request) {
    throw std::runtime_error(where + ": refused");
  }
  return *request;
}

/// A response's own length is the one that it has.
void expect_response_length(const Pdu& pdu, const std::string& where) {
  const PduLength length = response_length(pdu.bytes());
  EXPECT_EQ(length.kind, PduLength::Kind::known) << where;
  EXPECT_EQ(length.bytes, pdu.size()) << where;
}

/// Holds each response against the request that it answers; gives the number of those that fit.
std::size_t check_answers(const std::vector<manuals::Frame>& frames, std::size_t overhead) {
  std::map<std::pair<std::string, unsigned>, Request> requests;
  std::size_t fitting = 0;
  for (const manuals::Frame& frame : frames) {
    const Bytes pdu_bytes = Bytes(frame.bytes).subspan(1, frame.bytes.size() - overhead);
    const Pdu pdu = Pdu::from(pdu_bytes).value();
    if (frame.direction == Direction::request) {
      requests.emplace(std::pair(frame.manual, frame.line), request_of(pdu, frame.where()));
      continue;
    }
    expect_response_length(pdu, frame.where());
    if (!frame.answers) {
      continue;
    }
    const auto asked = requests.find({frame.manual, *frame.answers});
    if (asked == requests.end()) {
      ADD_FAILURE() << frame.where() << ": its request is missing";
      continue;
    }
    const auto fit = pdu.is_exception() ? ResponseFit::exception : ResponseFit::normal;
    EXPECT_EQ(check_response(asked->second, pdu.bytes()), fit) << frame.where();
    ++fitting;
  }
  return fitting;
}

TEST(ManualFrames, NoneIsLost) {
  std::map<std::string, unsigned> count;
  for (const manuals::Frame& frame : manuals::load_rtu()) {
    ++count[frame.manual];
  }
  EXPECT_EQ(count, (std::map<std::string, unsigned>{
                       {"moons-drives", 57}, {"rs485-stepper", 279}, {"higen-fda6000", 10}}));
  EXPECT_EQ(manuals::load_without_crc().size(), 16U);
  EXPECT_EQ(manuals::load_pairs().size(), 53U);
  EXPECT_EQ(manuals::load_misprints().size(), 10U);
}

TEST(ManualFrames, DecodeAndEncodeToThePrintedBytes) {
  for (const manuals::Frame& frame : manuals::load_rtu()) {
    ASSERT_TRUE(has_good_crc(frame.bytes)) << frame.where();
    const auto adu = decode_rtu(frame.bytes);
    ASSERT_TRUE(adu.has_value()) << frame.where();
    EXPECT_EQ(adu->address, frame.bytes[0]) << frame.where();
    EXPECT_THAT(encode_rtu(adu->address, adu->pdu), ElementsAreArray(frame.bytes)) << frame.where();
  }
}

TEST(ManualFrames, RequestsParseAndTheirResponsesFit) {
  EXPECT_EQ(check_answers(manuals::load_rtu(), kRtuOverhead), 157U);
}

TEST(ManualFrames, WithoutCrcParseAndFitToo) {
  EXPECT_EQ(check_answers(manuals::load_without_crc(), 1), 8U);
}

TEST(ManualFrames, RequestsOnTheTcpPortLookLikeRtu) {
  for (const manuals::Frame& frame : manuals::load_rtu()) {
    if (frame.direction == Direction::request) {
      EXPECT_TRUE(looks_like_rtu(frame.bytes)) << frame.where();
    }
  }
}

TEST(ManualPairs, TcpAduIsTheRtuFrameWithMbapInsteadOfCrc) {
  for (const manuals::Pair& pair : manuals::load_pairs()) {
    const auto adu = decode_rtu(pair.rtu);
    ASSERT_TRUE(adu.has_value()) << pair.where();
    const MbapScan scan = scan_mbap(pair.tcp);
    const auto* frame = std::get_if<MbapFrame>(&scan);
    ASSERT_NE(frame, nullptr) << pair.where();
    EXPECT_EQ(frame->size, pair.tcp.size()) << pair.where();
    EXPECT_EQ(frame->adu.header, (MbapHeader{0, adu->address})) << pair.where();
    EXPECT_EQ(frame->adu.pdu, adu->pdu) << pair.where();
    EXPECT_THAT(encode(frame->adu), ElementsAreArray(pair.tcp)) << pair.where();
    EXPECT_THAT(encode_rtu(adu->address, frame->adu.pdu), ElementsAreArray(pair.rtu))
        << pair.where();
    EXPECT_FALSE(looks_like_rtu(pair.tcp)) << pair.where();
  }
}

TEST(ManualPairs, ResponsesFitTheirRequests) {
  std::size_t answered = 0;
  const auto transactions = manuals::load_transactions();
  EXPECT_EQ(transactions.size(), 37U);
  for (const manuals::Transaction& transaction : transactions) {
    const Request request =
        request_of(decode_rtu(transaction.request.rtu).value().pdu, transaction.request.where());
    if (transaction.response) {
      const auto adu = decode_rtu(transaction.response->rtu).value();
      EXPECT_EQ(check_response(request, adu.pdu.bytes()), ResponseFit::normal)
          << transaction.response->where();
      ++answered;
    }
  }
  EXPECT_EQ(answered, 16U);
}

TEST(ManualMisprints, RtuFramesFailAsPrintedAndHoldCorrected) {
  for (const manuals::Misprint& misprint : manuals::load_misprints()) {
    if (misprint.kind == manuals::MisprintKind::rtu) {
      EXPECT_FALSE(decode_rtu(misprint.printed).has_value()) << misprint.where();
      EXPECT_TRUE(decode_rtu(misprint.right).has_value()) << misprint.where();
    }
  }
}

TEST(ManualMisprints, CorrectedTcpAdusAreInThePairs) {
  const auto pairs = manuals::load_pairs();
  unsigned seen = 0;
  for (const manuals::Misprint& misprint : manuals::load_misprints()) {
    if (misprint.kind == manuals::MisprintKind::tcp) {
      const auto pair = std::ranges::find(pairs, misprint.line - 1, &manuals::Pair::line);
      ASSERT_NE(pair, pairs.end()) << misprint.where();
      EXPECT_EQ(pair->tcp, misprint.right) << misprint.where();
      EXPECT_NE(pair->tcp, misprint.printed) << misprint.where();
      ++seen;
    }
  }
  EXPECT_EQ(seen, 3U);
}

// The length field says 27, 28 bytes follow: an ADU whose data has slipped by one, and one byte
// left over.
TEST(ManualMisprints, AnExtraByteStaysBehindTheAdu) {
  for (const manuals::Misprint& misprint : manuals::load_misprints()) {
    if (misprint.kind == manuals::MisprintKind::tcp && misprint.fault == "extra byte") {
      const auto frame = std::get<MbapFrame>(scan_mbap(misprint.printed));
      EXPECT_EQ(frame.size + 1, misprint.printed.size()) << misprint.where();
      EXPECT_TRUE(Request::parse(frame.adu.pdu).has_value()) << misprint.where();
    }
  }
}

TEST(ManualMisprints, ALengthTooLongWaitsForBytesThatNeverCome) {
  for (const manuals::Misprint& misprint : manuals::load_misprints()) {
    if (misprint.kind == manuals::MisprintKind::tcp && misprint.fault == "length") {
      EXPECT_TRUE(std::holds_alternative<MbapIncomplete>(scan_mbap(misprint.printed)));
      auto stream = misprint.printed;
      stream.insert(stream.end(), {0x00, 0x01});  // the head of the next request fills it up
      const auto frame = std::get<MbapFrame>(scan_mbap(stream));
      const auto request = Request::parse(frame.adu.pdu);
      ASSERT_FALSE(request.has_value());
      EXPECT_EQ(request.error(), ExceptionCode::illegal_data_value);
    }
  }
}

}  // namespace
}  // namespace mbgate::modbus

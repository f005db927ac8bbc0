// SPDX-License-Identifier: Apache-2.0
// How old what was read ahead counts as.
#include "gateway/clients/read_ahead.hpp"

#include <gtest/gtest.h>

#include "gateway/limits.hpp"

namespace mbgate::gateway {
namespace {

constexpr std::size_t kPieces = 100;

bus::Instant time_of(std::size_t piece) {
  return bus::Instant{} + std::chrono::milliseconds(piece);
}

/// Pieces of one byte, one each millisecond.
ReadAhead many_pieces() {
  ReadAhead input;
  for (std::size_t piece = 0; piece < kPieces; ++piece) {
    input.append(modbus::Bytes(std::vector<std::uint8_t>(1)), time_of(piece));
  }
  return input;
}

TEST(ReadAhead, ItsFirstAndItsLastPiecesAreAsOldAsTheyAre) {
  const ReadAhead input = many_pieces();
  for (std::size_t piece = 0; piece < kPieces; ++piece) {
    if (piece < kArrivalMarks - kLastMarks || piece >= kPieces - kLastMarks) {
      EXPECT_EQ(input.arrival_at(piece), time_of(piece));
    }
  }
}

TEST(ReadAhead, WhatLiesBetweenIsNeverYounger) {
  const ReadAhead input = many_pieces();
  for (std::size_t piece = kArrivalMarks - kLastMarks; piece < kPieces - kLastMarks; ++piece) {
    EXPECT_EQ(input.arrival_at(piece), time_of(kArrivalMarks - kLastMarks - 1));
  }
}

TEST(ReadAhead, NothingBecomesOlderThanTheReloadBeforeIt) {
  ReadAhead input = many_pieces();
  constexpr std::size_t kReloads = 3;
  for (std::size_t piece = kPieces; piece < (1 + kReloads) * kPieces; ++piece) {
    if (piece % kPieces == 0) {
      input.note_reload(time_of(piece));
    }
    input.append(modbus::Bytes(std::vector<std::uint8_t>(1)), time_of(piece));
  }
  for (std::size_t piece = 0; piece < input.size(); ++piece) {
    EXPECT_GE(input.arrival_at(piece), time_of(piece / kPieces * kPieces));
    EXPECT_LE(input.arrival_at(piece), time_of(piece));
  }
}

// Each piece is behind one.
TEST(ReadAhead, UnlessThereAreTooManyReloads) {
  ReadAhead input;
  for (std::size_t piece = 0; piece < kPieces; ++piece) {
    input.note_reload(time_of(piece));
    input.append(modbus::Bytes(std::vector<std::uint8_t>(1)), time_of(piece));
  }
  for (std::size_t piece = 0; piece < kPieces; ++piece) {
    const bool is_late = piece >= kPieces - (kArrivalMarks - 1);
    EXPECT_EQ(input.arrival_at(piece), time_of(is_late ? piece : 0));
  }
}

TEST(ReadAhead, ThereAreTimesAgainOnceSomeOfItWasTaken) {
  ReadAhead input = many_pieces();
  input.consume(kPieces - kLastMarks);
  for (std::size_t piece = kPieces; piece < kPieces + kArrivalMarks - kLastMarks; ++piece) {
    input.append(modbus::Bytes(std::vector<std::uint8_t>(1)), time_of(piece));
    EXPECT_EQ(input.arrival_at(input.size() - 1), time_of(piece));
  }
  EXPECT_EQ(input.arrival_at(0), time_of(kPieces - kLastMarks));
  EXPECT_EQ(input.arrival_at(kLastMarks), time_of(kPieces));
}

}  // namespace
}  // namespace mbgate::gateway

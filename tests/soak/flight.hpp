// SPDX-License-Identifier: Apache-2.0
// What went over a wire, as the oracle keeps it.
#pragma once

#include <cstdint>
#include <vector>

#include "drive/device.hpp"
#include "soak/asked.hpp"

namespace mbgate::soak {

/// A transmission of the gateway.
struct Flight {
  std::uint64_t number = 0;
  std::size_t bus = 0;
  std::uint8_t address = 0;
  std::uint16_t identifier = 0;  ///< on TCP buses
  PduBytes pdu;
  std::vector<std::uint64_t> asked;  ///< requests that it may be for
  bool is_stop = false;
  bool is_failsafe = false;  ///< the gateway's own
  bool is_repeated = false;  ///< a stop of which the tries are a series
  bool is_write = false;
  bool is_broadcast = false;
  bool repeats_read = false;
  bool surely_repeats = false;  ///< one request, for which alone the read was transmitted last
  std::optional<Instant> stop_from{};  ///< a stop that was not tried before waits since then
  bool is_part = false;                ///< of several transactions that stay together
  bool beside_stop = false;            ///< a stop waits that lets it go first, or gives way to it
  bool asks_order = false;             ///< whoever it is for, the gateway learns the word order
  bool meets_stop = false;             ///< one was accepted after it
  bool expects_answer = true;
  /// A frame may have been taken for its answer that cannot be told from it.
  bool is_uncertain = false;
  std::optional<Instant> paid_at{};       ///< its own answer began
  std::optional<std::uint8_t> refused{};  ///< its device answers this exception
  std::optional<Instant> refused_at{};    ///< it came then
  bool may_be_paid = false;               ///< something came that may have been taken for it
  bool is_answered = false;               ///< for certain: the answer met no fault
  bool needs_silence = false;             ///< behind that, because other bytes stood before it
  /// A whole answer came that fits, and this may have kept it from being taken.
  const char* unsure = nullptr;
  /// Of a read that several may share: the writes to its device that waited, and whom it answered
  /// alone; the numbers in which they were accepted.
  std::vector<std::uint64_t> waiting_writes{};
  std::vector<std::uint64_t> answered{};
  std::vector<std::uint64_t> merged_for{};  ///< of `asked`, who surely have a part of it
  bool is_for_each = false;                 ///< a read that was surely sent for all of `asked`
  bool has_whole_echo = false;  ///< it was read; another one may look like a damaged answer
  bool echo_pauses = false;     ///< it was read in two parts, the first of which ended as an answer
  bool is_crowded = false;      ///< all places on its connection were taken beside it
  bool is_cut_off = false;      ///< its line or connection has gone meanwhile
  bool is_named = false;        ///< what came has its address and function, one behind the other
  std::size_t came = 0;  ///< bytes that reached the kernel before anything else was transmitted
  Instant first_came = Instant::max();  ///< the first of these
  std::size_t size = 0;                 ///< of its frame
  Instant begin;
  Instant end;
  Instant deadline;            ///< the first byte of its answer must be there
  Instant due;                 ///< the same if no stop cuts it
  Instant quarantine_until;    ///< a later answer is still kept from others
  drive::DeviceTiming timing;  ///< of its device when it was sent
};

/// Of an answer that names another function than was asked for.
constexpr std::uint8_t mistaken(std::uint8_t function) {
  return static_cast<std::uint8_t>(function ^ 0x05U);
}

/// Does an answer to the one look like one to the other?
bool may_be_confused(const PduBytes& a, const PduBytes& b);

/// Does its echo look like its answer?
bool looks_like_answer(const Flight& flight);

/// A good frame that ends in a piece of bytes.
struct HeardFrame {
  std::uint8_t address = 0;
  bool fits = true;          ///< it answers what was asked
  bool is_nobodys = false;   ///< nobody here asked for it, or it was said before
  std::uint64_t flight = 0;  ///< that it answers
  Instant began;             ///< when its first byte reached the kernel
  bool is_refused = false;   ///< it came too early to be an answer to what was asked last
  bool waits = false;        ///< what it is depends on when the gateway reads it
  /// It may be taken for an answer, because of this.
  const char* excuse = nullptr;
  std::size_t size = 0;
  std::size_t lead = 0;       ///< bytes that were put before it
  Instant ended{};            ///< when its last byte reached the kernel
  bool is_only_debt = false;  ///< its device owed nothing else then
  bool is_second = false;     ///< the same device has answered it before
  std::size_t came = 0;       ///< bytes since the last own transmission, with its own
};

/// What a line has heard of an own transmission.
struct HeardEcho {
  std::uint64_t flight = 0;
  std::size_t size = 0;
  bool is_whole = true;  ///< and as it was sent
  Instant began;         ///< when its first byte reached the kernel
  bool in_one = true;    ///< all of it came at once
};

}  // namespace mbgate::soak

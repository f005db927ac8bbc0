// SPDX-License-Identifier: Apache-2.0
// What has really happened in a small world: who asked what, what was transmitted, and what became
// of its answers.
#pragma once

#include <optional>
#include <vector>

#include "explore/plant.hpp"
#include "explore/state_hash.hpp"
#include "world/frames.hpp"

namespace mbgate::explore {

using Octets = std::vector<std::uint8_t>;

struct Ask {
  std::uint8_t client = 0;
  std::uint8_t device = 0;
  Word word = Word::read_a;

  [[nodiscard]] bool is_read() const { return word == Word::read_a || word == Word::read_b; }
  friend bool operator==(const Ask&, const Ask&) = default;
};

/// Requests that may be open at a time.
inline constexpr std::size_t kSlots = 4;

struct Request {
  bool open = false;
  bool taken = false;        ///< the gateway has it; before, it lies in its socket
  bool cancelled = false;    ///< a stop was taken that takes it back
  bool repeats = false;      ///< a stop that was acknowledged a moment before
  bool was_offline = false;  ///< its device was, while it was open
  Ask ask;
  std::uint64_t event = 0;  ///< when it was taken, among all events
  Instant since;            ///< it was taken
  Instant deadline;
  unsigned sent = 0;              ///< transmissions that it had a part in
  int rivals = 1;                 ///< it, and other writes and stops that were open beside it
  std::uint64_t must_follow = 0;  ///< what is read was asked after this: an acknowledged write
};

struct Flight {
  std::uint16_t serial = 0;
  std::uint8_t device = 0;
  Word word = Word::read_a;
  std::uint16_t value = 0;  ///< of a write
  std::uint64_t event = 0;
  Instant left;                       ///< the end of the request on the wire
  Instant due;                        ///< and of its response timeout
  Instant begins;                     ///< a slow device begins with it
  bool outstanding = true;            ///< its answer may still come
  bool late = false;                  ///< it did not come in time, which was counted as a fault
  bool spoilt = false;                ///< it came damaged, or not whole, or what may have been it
  bool heard = false;                 ///< it was handed in, good
  bool open = true;                   ///< nothing has come that may be its answer
  bool cut = false;                   ///< a stop may have ended the wait for it
  bool in_time = false;               ///< while it was waited for
  bool perhaps = false;               ///< what came meanwhile may have been taken for its answer
  std::optional<Instant> first_at{};  ///< the first of its two answers came
  std::optional<Instant> half_at{};   ///< its first half came
  bool rest_comes = false;            ///< and the other one may still come
};

/// What a device is to say or has been told.
Octets pdu_of(Word word, std::uint16_t value);
/// A frame that answers the flight; a read shows which transmission and which register it answers.
Octets answer_of(const Flight& flight);
/// What a read shows in its second register.
constexpr std::uint16_t tag_of(std::uint8_t device, Word word) {
  return static_cast<std::uint16_t>((device + 1U) << 8U | static_cast<unsigned>(word));
}
/// Can the answers be mistaken for each other?
bool looks_alike(Word a, Word b);

std::string name_of(const Ask& ask);

}  // namespace mbgate::explore

// SPDX-License-Identifier: Apache-2.0
// What begins among the bytes of an RTU line: the answer to one request, another's frame, or
// nothing. It only looks.
//
// Bytes that are no part of a frame may stand before one: drivers turning on, glitches. Of these
// fewer are skipped than a request like the own one has, 7 at most, and never for an unknown
// function, whose beginning only they would tell. Nothing is taken out of another's frame: a good
// one of any unit is found whole, and while one that may have begun further ahead is incomplete,
// what looks like the response waits for silence, as an exception after such bytes always does,
// because it is so short.
#pragma once

#include <optional>

#include "bus/instant.hpp"
#include "bus/job.hpp"
#include "bus/serial/received_bytes.hpp"
#include "modbus/response.hpp"
#include "modbus/rtu_timing.hpp"

namespace mbgate::bus {

/// How far the answer has come.
enum class Answer : std::uint8_t {
  not_begun,
  incomplete,
  opaque,   ///< of an unknown function: silence ends it
  bad_crc,  ///< complete, with a wrong CRC: silence must confirm that it is complete
  unsure    ///< complete and good, but it may be a part of something else, unless silence follows
};

/// What begins at a place among the bytes.
struct RtuFind {
  enum class What : std::uint8_t {
    nothing,
    unfinished,  ///< perhaps another's frame, of which bytes are missing
    answer,      ///< perhaps the answer; `answer` says what is missing
    response,    ///< the answer
    other,       ///< a good frame, and no answer
    request,     ///< of another client
    echo         ///< of the own request
  };
  What what = What::nothing;
  std::size_t at = 0;
  std::size_t size = 0;  ///< of a response, another frame or an echo
  Answer answer = Answer::not_begun;
};

class RtuSearch {
 public:
  /// For the answer to `transaction`, if anything was asked, which had left at `sent` if the line
  /// keeps its pace.
  RtuSearch(const ReceivedBytes& received, const Transaction* transaction,
            const modbus::RtuTiming& timing, Instant sent)
      : received_(received), transaction_(transaction), timing_(timing), sent_(sent) {}

  /// The first thing that begins. `silence`: nothing more comes, and what is incomplete stays so.
  [[nodiscard]] RtuFind look(bool silence) const;
  /// Do the bytes begin with the unit and the function that were asked?
  [[nodiscard]] bool begins_as_asked(modbus::Bytes bytes) const;
  /// How long the answer is that these bytes begin; or else what was asked says, while the byte
  /// count is missing too.
  [[nodiscard]] modbus::PduLength length_of(modbus::Bytes answer) const;
  /// Is what has come whole by then what was sent itself? No later than that has begun on the line,
  /// and by then nobody else had.
  [[nodiscard]] bool is_echo(std::uint8_t address, modbus::Bytes pdu, Instant last) const;

 private:
  struct Place {
    std::size_t at = 0;
    bool unfinished = false;  ///< another's frame may have begun further ahead
    bool silence = false;
  };
  [[nodiscard]] std::size_t most_noise() const;
  [[nodiscard]] RtuFind look_at(const Place& place) const;
  [[nodiscard]] RtuFind look_at_candidate(const Place& place) const;
  [[nodiscard]] std::optional<RtuFind> look_at_echo(const Place& place, std::size_t size) const;
  [[nodiscard]] RtuFind look_at_stranger(const Place& place) const;
  [[nodiscard]] bool may_begin_answer(std::size_t at) const;
  [[nodiscard]] modbus::Bytes bytes_from(std::size_t at) const {
    return received_.bytes().subspan(at);
  }

  const ReceivedBytes& received_;
  const Transaction* transaction_;
  const modbus::RtuTiming& timing_;
  Instant sent_;
};

}  // namespace mbgate::bus

// SPDX-License-Identifier: Apache-2.0
// Finds what begins among the bytes of an RTU line: the answer to one request, another frame, or
// nothing. It only looks.
//
// Bytes that are no part of a frame may come before one: line drivers turning on, glitches. At most
// 7 of them are skipped, and fewer than the own request has bytes. None are skipped for an unknown
// function: its answer could be recognised only by its first two bytes.
//
// The answer is never found inside another frame: a valid frame of any unit is recognised as a
// whole. While a frame that may have begun earlier is incomplete, what looks like the response
// waits for silence. An exception behind skipped bytes always waits for silence, because it is so
// short.
#pragma once

#include <boost/container/static_vector.hpp>
#include <optional>

#include "bus/instant.hpp"
#include "bus/job.hpp"
#include "bus/line_end.hpp"
#include "modbus/response.hpp"
#include "modbus/rtu_timing.hpp"

namespace mbgate::bus {

/// Room for a whole frame and for what may come before or after it in the same read.
inline constexpr std::size_t kMostBuffered = 1024;

/// Bytes received from the line and not yet assigned to frames, each with its time of arrival. A
/// frame begins when its own first byte came.
class ReceivedBytes {
 public:
  /// False, and nothing is taken, if there is no room for all of them.
  [[nodiscard]] bool add(modbus::Bytes bytes, Instant now) {
    if (bytes_.size() + bytes.size() > bytes_.capacity()) {
      return false;
    }
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    came_.resize(bytes_.size(), now);
    return true;
  }
  /// Removes the first `count` bytes, which must be there.
  void drop(std::size_t count) {
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(count));
    came_.erase(came_.begin(), came_.begin() + static_cast<std::ptrdiff_t>(count));
  }
  void clear() {
    bytes_.clear();
    came_.clear();
  }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  [[nodiscard]] modbus::Bytes bytes() const { return {bytes_.data(), bytes_.size()}; }
  [[nodiscard]] Instant came_at(std::size_t at) const { return came_[at]; }

 private:
  boost::container::static_vector<std::uint8_t, kMostBuffered> bytes_;
  boost::container::static_vector<Instant, kMostBuffered> came_;
};

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
    unfinished,  ///< perhaps another frame, of which bytes are missing
    answer,      ///< perhaps the answer; `answer` says what is missing
    response,    ///< the answer
    other,       ///< a valid frame that is not the answer
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
  /// Searches for the answer to `transaction` (nullptr: no request is pending). `sent`: when the
  /// request had left, if the line keeps the speed of the wire.
  RtuSearch(const ReceivedBytes& received, const Transaction* transaction,
            const modbus::RtuTiming& timing, Instant sent)
      : received_(received), transaction_(transaction), timing_(timing), sent_(sent) {}

  /// The first frame that begins. `silence`: nothing more comes, and what is incomplete stays so.
  [[nodiscard]] RtuFind look(bool silence) const;
  /// May the first byte be that of the answer? Not if the length or the CRC has shown already that
  /// it is not, nor if it is all that has come.
  [[nodiscard]] bool is_beginning_of_answer() const;
  /// The length of the answer that begins with these bytes. While the byte count has not come, it
  /// is the length that the request predicts.
  [[nodiscard]] modbus::PduLength length_of(modbus::Bytes answer) const;
  /// Is this frame, whose last byte came at `last`, the echo of the own request? It is if it is
  /// identical to the request and had begun on the line before the request had left: no other
  /// client can have begun to send by then.
  [[nodiscard]] bool is_echo(std::uint8_t address, modbus::Bytes pdu, Instant last) const;

 private:
  struct Place {
    std::size_t at = 0;
    bool unfinished = false;  ///< another frame may have begun earlier
    bool silence = false;
  };
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

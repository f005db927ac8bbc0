// SPDX-License-Identifier: Apache-2.0
// A good answer ends a request, and a read is not given up before it was tried as often as its
// device's settings say.
#include <algorithm>

#include "soak/oracle.hpp"

namespace mbgate::soak {

// It is asked once more, or was told that there is no answer.
void Oracle::check_answered(const Asked& asked) {
  if (stopping_) {
    return;
  }
  const Flight* last = asked.last_alone != 0 ? flight(asked.last_alone) : nullptr;
  if (last != nullptr && last->is_answered && !last->is_cut_off && asked.pieces.size() == 1 &&
      books_[last->bus].last_down < last->begin) {
    violation("answer_lost",
              name(asked) + ", answered " +
                  std::to_string((schedule_.now() - last->begin) / std::chrono::microseconds(1)) +
                  " us after it was transmitted");
  }
}

// It was told that there is no answer. Who shares a read has been there since its first try; where
// others asked for the same apart, some tries may have been theirs, and it had fewer.
void Oracle::judge_tries(const Asked& asked) {
  if (stopping_) {
    return;
  }
  if (!asked.is_read() || !asked.door->device || asked.pieces.size() != 1 || asked.ordered ||
      asked.flights == 0 || may_be_offline(asked)) {
    return;
  }
  const Piece& piece = asked.pieces.front();
  const Book& book = books_[piece.bus];
  const unsigned retries = devices_[*asked.door->device].settings().timing.retries;
  const bool may_end = schedule_.now() >= asked.deadline - (asked.written - asked.earliest) ||
                       book.last_down >= asked.accepted || reloaded_ >= asked.accepted ||
                       piece.taken_back || is_tcp(piece.bus) || bus_settings(piece.bus).merge;
  if (!may_end && asked.flights < 1 + retries) {
    violation("given_up", name(asked) + " after " + std::to_string(asked.flights) + " tries");
  }
}

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
// Whether there was a path (0A): a line that was away, or a device that was offline.
#include <algorithm>

#include "soak/oracle.hpp"
#include "soak/refusals.hpp"

namespace mbgate::soak {

bool Refusals::is_away(const Asked& asked) const {
  return std::ranges::any_of(asked.pieces, [&](const Piece& piece) {
    const Book& book = oracle_.books_[piece.bus];
    return (!book.open && !book.starting) || book.last_down >= asked.accepted;
  });
}

// One form of a broadcast was transmitted, and its line was lost before another one. Where nothing
// was transmitted there was no path.
bool Refusals::was_cut_short(const Asked& broadcast) const {
  return std::ranges::any_of(broadcast.pieces, [&](const Piece& piece) {
    return piece.sent > 0 && oracle_.books_[piece.bus].last_down >= broadcast.accepted;
  });
}

// One of its lines has been away since before it came, or was lost before it was transmitted there,
// which nothing else has kept it from: whatever became of it on others.
bool Refusals::found_no_path(const Asked& broadcast) const {
  return std::ranges::any_of(broadcast.pieces, [&](const Piece& piece) {
    const Book& book = oracle_.books_[piece.bus];
    const bool is_sent = std::ranges::any_of(
        broadcast.pieces, [&](const Piece& it) { return it.bus == piece.bus && it.sent > 0; });
    const bool was_kept = piece.doomed || why_withdrawn(broadcast) != nullptr ||
                          oracle_.stopping_ || book.last_full >= broadcast.accepted;
    return !is_sent &&
           (book.last_down >= broadcast.accepted ? !was_kept : !book.open && !book.starting);
  });
}

void Refusals::judge_no_path(const Asked& asked) const {
  if (asked.surely_on_wire && oracle_.is_apart(asked, "refused_")) {
    return;  // by an exception to something else
  }
  if (asked.surely_on_wire && asked.kind != Kind::broadcast) {
    oracle_.violation("no_path_after_wire", oracle_.name(asked));
  } else if (const char* reason = why_no_path(asked); reason != nullptr) {
    note("0A", reason);
  } else {
    oracle_.violation("no_path_without_reason", oracle_.name(asked));
  }
}

const char* Refusals::why_no_path(const Asked& asked) const {
  if (is_away(asked)) {
    return "line_away";
  }
  return !asked.is_read() && oracle_.may_be_offline(asked) ? "offline" : nullptr;
}

}  // namespace mbgate::soak

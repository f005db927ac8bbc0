// SPDX-License-Identifier: Apache-2.0
// Wrong values and false acknowledgements that physics excuses, counted apart and bounded: a device
// that answers later than its settings say, or twice, is known after a few. So at a start five of
// them may come, within twenty response timeouts, and then none until something new is there to
// be learned: the device is later than it has ever been, says something again after a longer while,
// or the process has started anew.
#include <string_view>

#include "soak/oracle.hpp"

namespace mbgate::soak {
namespace {

constexpr int kTimeoutsOfAStart = 20;

bool is_bounded(std::string_view uncertain) {
  return uncertain != kStrangers && uncertain.find("echo") == std::string_view::npos;
}

}  // namespace

// Several clients may have shared the transmission: that is one. What a stranger has asked for, or
// an echo, teaches nobody anything.
void Oracle::count_slip(const Asked& asked) {
  const Piece& piece = asked.pieces.front();
  Slips& slips = books_[piece.bus].lanes[piece.address].slips;
  const Flight* last = flight(asked.last_flight);
  if (last == nullptr || last->number == slips.flight || !last->is_uncertain ||
      asked.uncertain == nullptr || !is_bounded(asked.uncertain)) {
    return;
  }
  slips.flight = last->number;
  const Instant now = schedule_.now();
  const Duration start = kTimeoutsOfAStart * (last->due - last->end) + 2 * lateness();
  const std::string where = name(asked) + ", " + asked.uncertain;
  if (now >= slips.until) {
    if (std::max(slips.caused, books_[piece.bus].opened) <= slips.until) {
      violation("wrong_again", where + ", though nothing is new");
    }
    slips.until = now + start;
    slips.wrong = 0;
    ++slips.starts;
  }
  const auto& device = books_[piece.bus].lanes[piece.address].device;
  const unsigned most = device ? plan_.ways[*device].most_wrong : kMostAtAStart;
  if (++slips.wrong > most) {
    violation("wrong_too_often", where + ", " + std::to_string(slips.wrong) + " since a start");
  }
  ++report_.starts[bus_settings(piece.bus).name + " address " + std::to_string(piece.address) +
                   " opening " + std::to_string(books_[piece.bus].openings) + " start " +
                   std::to_string(slips.starts)];
}

}  // namespace mbgate::soak

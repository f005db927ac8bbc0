// SPDX-License-Identifier: Apache-2.0
// An answer that pauses for nearly as long as it may, goes on, and breaks off: what is missing has
// no more time than if it had not gone on.
#include "soak/serial_wire.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

bool SerialWire::gets_stuck(const Flight& flight, const Frame& frame, Instant begin) {
  constexpr std::size_t kHead = 4;  // by then its length is known
  constexpr std::size_t kCrc = 2;
  const Duration pause = spec::slack_of(settings_) - 5ms - silence_;
  if (ascii_ || opaque_ || is_prompt_ || frame.size() < kHead + kCrc + 2 || pause < 5ms ||
      !happens_to_echo(rates_.stuck, "stuck")) {
    return false;
  }
  Frame head(frame.begin(), frame.begin() + kHead);
  // Of the CRC nothing comes: one byte that is missing might stand by chance at the front of what
  // is heard next.
  const auto missing = static_cast<std::ptrdiff_t>(echo_random_.between(kCrc, kCrc + 1));
  Frame rest(frame.begin() + kHead, frame.end() - missing);
  const Instant goes_on = begin + timing_.of(head.size()) + pause;
  talks_until_[flight.address] = goes_on + timing_.of(rest.size());
  const Content nobodys{std::nullopt, 1, 0, false, flight.number};
  say(std::move(head), begin, Chunks::fine, nobodys);
  say(std::move(rest), goes_on, Chunks::fine, nobodys);
  return true;
}

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
#include "sim/live_bus.hpp"

#include <algorithm>

namespace mbgate::sim {
namespace {

// Longer than a process that writes a request in parts is kept waiting between them.
constexpr Duration kShortestSilence = std::chrono::milliseconds(20);

Duration framing_silence(const WireSettings& wire) {
  return std::max(kShortestSilence, modbus::RtuTiming(wire.baud, wire.format).t3_5());
}

}  // namespace

LiveBus::LiveBus(const BusSettings& settings)
    : name_(settings.name),
      link_(settings.link),
      framer_(framing_silence(settings.wire)),
      wire_(settings.wire, settings.devices) {}

std::optional<std::string> LiveBus::connect() {
  auto opened = Pty::open(link_);
  if (!opened) {
    return "bus " + name_ + ": " + opened.error();
  }
  pty_.emplace(*std::move(opened));
  return std::nullopt;
}

void LiveBus::disconnect() {
  pty_.reset();
  framer_.clear();
  wire_.disconnect();
}

void LiveBus::handle_readable(Instant now) {
  const auto bytes = pty_->read();
  // The end of an ASCII frame is seen on the wire itself.
  if (wire_.settings().framing == Framing::ascii) {
    wire_.transmit(bytes, now);
  } else {
    framer_.feed(bytes, now);
  }
  handle_time(now);
}

void LiveBus::handle_time(Instant now) {
  while (const auto frame = framer_.poll(now)) {
    wire_.transmit(frame->bytes, frame->begin);
  }
  const auto bytes = wire_.advance(now);
  if (pty_ && !bytes.empty()) {
    pty_->write(bytes);
  }
}

std::optional<Instant> LiveBus::next_event() const {
  return bus::earlier(framer_.deadline(), wire_.next_event());
}

std::string LiveBus::introduction() const {
  return "bus " + name_ + ' ' + link_.string() + " (" + (pty_ ? pty_->path() : "closed") + ')';
}

std::string LiveBus::counters_text() const {
  const WireCounters& counters = wire_.counters();
  return "bus " + name_ + ": frames " + std::to_string(counters.frames) + ", answers " +
         std::to_string(counters.answers) + ", silence violations " +
         std::to_string(counters.silence_violations) + ", collisions " +
         std::to_string(counters.collisions) + ", bad CRC " + std::to_string(counters.bad_crc);
}

}  // namespace mbgate::sim

// SPDX-License-Identifier: Apache-2.0
#include "sim/program/live_bus.hpp"

#include <algorithm>
#include <fmt/core.h>

namespace mbgate::sim {
namespace {

// Longer than a process that writes a request in parts is kept waiting between them.
constexpr Duration kShortestSilence = std::chrono::milliseconds(20);

Duration framing_silence(const WireSettings& wire) {
  return std::max(kShortestSilence, modbus::RtuTiming(wire.baud, wire.format).t3_5());
}

// A serial device server has one client at a time: two would talk into each other's transactions.
constexpr std::size_t kSerialServerConnections = 1;

// More than any client or gateway opens; beyond it, something is wrong.
constexpr std::size_t kMostConnections = 64;

}  // namespace

LiveBus::LiveBus(const BusSettings& settings)
    : name_(settings.name),
      link_(settings.link),
      address_(settings.listen),
      framer_(framing_silence(settings.wire)),
      wire_(settings.wire, settings.devices) {}

std::optional<std::string> LiveBus::connect() {
  if (address_) {
    return listen();
  }
  const WireSettings& wire = wire_.settings();
  auto opened = Pty::open(link_, {wire.baud, wire.format.stop_bits});
  if (!opened) {
    return fmt::format("bus {}: {}", name_, opened.error());
  }
  pty_.emplace(*std::move(opened));
  return std::nullopt;
}

std::optional<std::string> LiveBus::listen() {
  auto opened = TcpPort::open(*address_, kSerialServerConnections);
  if (!opened) {
    return fmt::format("bus {}: {}", name_, opened.error());
  }
  port_.emplace(*std::move(opened));
  address_ = port_->address();
  return std::nullopt;
}

void LiveBus::disconnect() {
  pty_.reset();
  port_.reset();
  framer_.clear();
  wire_.disconnect();
}

std::vector<int> LiveBus::descriptors() const {
  if (port_) {
    return port_->descriptors();
  }
  return pty_ ? std::vector{pty_->descriptor()} : std::vector<int>{};
}

void LiveBus::release_exclusive() const {
  if (pty_) {
    pty_->release_exclusive();
  }
}

std::vector<std::uint8_t> LiveBus::receive() {
  std::vector<std::uint8_t> bytes;
  if (pty_) {
    return pty_->read();
  }
  for (const TcpPort::Received& received : port_->receive()) {
    bytes.insert(bytes.end(), received.bytes.begin(), received.bytes.end());
  }
  return bytes;
}

void LiveBus::read_mode() {
  const auto speed = pty_ ? pty_->speed() : std::nullopt;
  if (speed) {
    PortMode mode{speed->baud, wire_.settings().format};
    mode.format.stop_bits = speed->stop_bits;
    wire_.set_port(mode);
  }
}

void LiveBus::handle_readable(Instant now) {
  read_mode();
  const auto bytes = receive();
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
  if (bytes.empty()) {
    return;
  }
  if (pty_) {
    pty_->write(bytes);
  } else if (port_) {
    port_->send(bytes);
  }
}

std::optional<Instant> LiveBus::next_event() const {
  return bus::earlier(framer_.deadline(), wire_.next_event());
}

std::string LiveBus::introduction() const {
  if (address_) {
    return fmt::format("bus {} {}", name_, address_->text());
  }
  return fmt::format("bus {} {} ({})", name_, link_.string(), pty_ ? pty_->path() : "closed");
}

std::string LiveBus::counters_text() const {
  const WireCounters& counters = wire_.counters();
  return fmt::format(
      "bus {}: frames {}, answers {}, silence violations {}, collisions {}, bad CRC {}", name_,
      counters.frames, counters.answers, counters.silence_violations, counters.collisions,
      counters.bad_crc);
}

LiveTcpBus::LiveTcpBus(const BusSettings& settings)
    : name_(settings.name),
      address_(settings.listen.value_or(ListenAddress{})),
      bus_(settings.devices, settings.wire.paced) {}

std::optional<std::string> LiveTcpBus::connect() {
  auto opened = TcpPort::open(address_, kMostConnections);
  if (!opened) {
    return fmt::format("bus {}: {}", name_, opened.error());
  }
  port_.emplace(*std::move(opened));
  address_ = port_->address();
  return std::nullopt;
}

void LiveTcpBus::disconnect() {
  port_.reset();
  bus_.forget_all();
}

std::vector<int> LiveTcpBus::descriptors() const {
  return port_ ? port_->descriptors() : std::vector<int>{};
}

void LiveTcpBus::handle_readable(Instant now) {
  for (const TcpPort::Received& received : port_->receive()) {
    const bool sane = bus_.receive(received.connection, received.bytes, now);
    if (!sane || received.closed) {
      port_->close(received.connection);
      bus_.forget(received.connection);
    }
  }
  handle_time(now);
}

void LiveTcpBus::handle_time(Instant now) {
  for (const TcpResponse& response : bus_.advance(now)) {
    if (port_) {
      port_->send(response.connection, {response.bytes.data(), response.bytes.size()});
    }
  }
}

std::string LiveTcpBus::introduction() const {
  return fmt::format("bus {} {}", name_, address_.text());
}

std::string LiveTcpBus::counters_text() const {
  return fmt::format("bus {}: requests {}, answers {}", name_, bus_.counters().requests,
                     bus_.counters().answers);
}

}  // namespace mbgate::sim

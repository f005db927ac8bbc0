// SPDX-License-Identifier: Apache-2.0
#include "sim/program/live_tcp_bus.hpp"

namespace mbgate::sim {
namespace {

// More than any client or gateway opens; beyond it, something is wrong.
constexpr std::size_t kMostConnections = 64;

}  // namespace

LiveTcpBus::LiveTcpBus(const BusSettings& settings)
    : name_(settings.name),
      address_(settings.listen.value_or(ListenAddress{})),
      bus_(settings.devices, settings.wire.paced) {}

std::optional<std::string> LiveTcpBus::connect() {
  auto opened = TcpPort::open(address_, kMostConnections);
  if (!opened) {
    return "bus " + name_ + ": " + opened.error();
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

std::string LiveTcpBus::introduction() const { return "bus " + name_ + ' ' + address_.text(); }

std::string LiveTcpBus::counters_text() const {
  return "bus " + name_ + ": requests " + std::to_string(bus_.counters().requests) + ", answers " +
         std::to_string(bus_.counters().answers);
}

}  // namespace mbgate::sim

// SPDX-License-Identifier: Apache-2.0
#include "sim/wire/tcp_bus.hpp"

#include <algorithm>
#include <variant>

namespace mbgate::sim {

TcpBus::TcpBus(const std::vector<DeviceSettings>& devices, bool paced) {
  for (const DeviceSettings& settings : devices) {
    devices_.push_back({Device(with_processing(settings, paced))});
  }
}

bool TcpBus::receive(ConnectionId connection, modbus::Bytes bytes, Instant now) {
  std::vector<std::uint8_t>& stream = streams_[connection];
  stream.insert(stream.end(), bytes.begin(), bytes.end());
  for (;;) {
    const modbus::MbapScan scan = modbus::scan_mbap(stream);
    std::size_t size = 0;
    if (const auto* frame = std::get_if<modbus::MbapFrame>(&scan)) {
      serve(connection, frame->adu, now);
      size = frame->size;
    } else if (const auto* foreign = std::get_if<modbus::MbapForeign>(&scan)) {
      size = foreign->size;
    } else {
      return std::holds_alternative<modbus::MbapIncomplete>(scan);
    }
    stream.erase(stream.begin(), stream.begin() + static_cast<std::ptrdiff_t>(size));
  }
}

void TcpBus::forget(ConnectionId connection) {
  streams_.erase(connection);
  std::erase_if(due_, [connection](const TcpResponse& response) {
    return response.connection == connection;
  });
}

void TcpBus::forget_all() {
  streams_.clear();
  due_.clear();
}

std::optional<Instant> TcpBus::next_event() const {
  return due_.empty() ? std::nullopt : std::optional(due_.front().at);
}

std::vector<TcpResponse> TcpBus::advance(Instant now) {
  const auto end = std::ranges::upper_bound(due_, now, {}, &TcpResponse::at);
  std::vector<TcpResponse> responses(due_.begin(), end);
  due_.erase(due_.begin(), end);
  return responses;
}

Device* TcpBus::device(std::uint8_t unit) {
  const auto found = std::ranges::find(
      devices_, unit, [](const Served& served) { return served.device.settings().address; });
  return found == devices_.end() ? nullptr : &found->device;
}

// There is no broadcast on Ethernet: unit 0 is a unit like any other.
void TcpBus::serve(ConnectionId connection, const modbus::MbapAdu& adu, Instant now) {
  ++counters_.requests;
  const std::uint8_t unit = adu.header.unit;
  const auto served = std::ranges::find(
      devices_, unit, [](const Served& each) { return each.device.settings().address; });
  if (served == devices_.end()) {
    return;
  }
  const auto reply = served->device.receive(modbus::RtuAdu{unit, adu.pdu}, now);
  if (!reply) {
    return;
  }
  ++counters_.answers;
  const Instant begin = reply->counts_from_end ? now : std::max(now, served->free_at);
  const Instant at = begin + reply->after;
  served->free_at = std::max(served->free_at, at);
  const modbus::MbapHeader header{adu.header.transaction, reply->adu.address};
  const auto place = std::ranges::upper_bound(due_, at, {}, &TcpResponse::at);
  due_.insert(place, {at, connection, modbus::encode({header, reply->adu.pdu})});
}

}  // namespace mbgate::sim

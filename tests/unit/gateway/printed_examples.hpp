// SPDX-License-Identifier: Apache-2.0
// A gateway with one open line and identity routes, in virtual time, and the printed examples of
// the manuals in the form in which they go through it.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <map>
#include <set>

#include "gateway/gateway.hpp"
#include "manuals/vectors.hpp"
#include "modbus/rtu.hpp"

namespace mbgate::gateway::printed {

using manuals::ByteList;
using std::chrono::milliseconds;
using std::chrono::seconds;

inline constexpr BusId kBus{0};
inline constexpr ListenerId kRouted{0};
inline constexpr ListenerId kTransparent{1};
inline constexpr Duration kLong = seconds(5);

inline Settings make_settings() {
  Settings settings;
  settings.listeners.resize(2);
  settings.listeners[0].name = "routed";
  settings.listeners[1].name = "transparent";
  settings.listeners[1].bus = kBus;
  for (ListenerSettings& listener : settings.listeners) {
    listener.pipeline = 64;
  }
  settings.buses.resize(1);
  settings.buses[0].name = "line";
  routing::Route identity;
  identity.first_unit = 1;
  identity.last_unit = 247;
  identity.buses = {kBus};
  identity.first_address = 1;
  settings.routes = {identity};
  return settings;
}

inline ByteList rtu_of(std::uint8_t address, const ByteList& pdu) {
  const modbus::RtuBytes frame = modbus::encode_rtu(address, modbus::Pdu::from(pdu).value());
  return {frame.begin(), frame.end()};
}

/// The TCP message of an RTU frame with a right CRC: MBAP with transaction identifier 0, and the
/// same PDU.
inline ByteList tcp_of(const ByteList& rtu) {
  ByteList tcp{0, 0, 0, 0, 0, static_cast<std::uint8_t>(rtu.size() - 2)};
  tcp.insert(tcp.end(), rtu.begin(), rtu.end() - 2);
  return tcp;
}

/// A gateway with one open line, and a hand that moves time and keeps what the machine wants done.
class Bench {
 public:
  Bench() : gateway_(make_settings(), Instant{}) {
    collect();
    advance(seconds(2));  // listen_first
  }

  ClientId connect(ListenerId listener) {
    const ClientId client{++last_client_};
    const auto address =
        routing::ClientAddress::parse("192.0.2." + std::to_string(last_client_)).value();
    gateway_.handle_client_connected(client, {listener, address, 0}, now_);
    collect();
    return client;
  }

  void from_client(ClientId client, modbus::Bytes bytes) {
    gateway_.handle_client_bytes(client, bytes, now_);
    collect();
  }

  void from_line(modbus::Bytes bytes) {
    gateway_.handle_bus_bytes(kBus, bytes, now_);
    collect();
  }

  void advance(Duration time) {
    run_until([] { return false; }, time);
  }

  /// The next frame on the line, or none if none is transmitted within `limit`.
  ByteList next_frame(Duration limit = kLong) {
    run_until([this] { return !frames_.empty(); }, limit);
    return take(frames_);
  }

  /// The next ADU for the client, or none.
  ByteList next_adu(ClientId client, Duration limit = kLong) {
    run_until([&] { return !adus_[client].empty(); }, limit);
    return take(adus_[client]);
  }

  [[nodiscard]] bool is_closed(ClientId client) const { return closed_.contains(client); }

  template <typename Wanted>
  [[nodiscard]] std::size_t events() const {
    return static_cast<std::size_t>(std::ranges::count_if(
        events_, [](const Event& event) { return std::holds_alternative<Wanted>(event); }));
  }

 private:
  static ByteList take(std::deque<ByteList>& queue) {
    if (queue.empty()) {
      return {};
    }
    ByteList bytes = queue.front();
    queue.pop_front();
    return bytes;
  }

  void run_until(const std::function<bool()>& done, Duration limit) {
    const Instant end = now_ + limit;
    while (!done()) {
      const auto deadline = gateway_.next_deadline();
      if (!deadline || *deadline > end) {
        now_ = end;
        return;
      }
      now_ = std::max(now_, *deadline);
      gateway_.handle_deadline(now_);
      collect();
    }
  }

  void collect() {
    while (const auto action = gateway_.poll_action()) {
      if (const auto* send = std::get_if<Send>(&*action)) {
        adus_[send->client].push_back({send->adu.begin(), send->adu.end()});
        gateway_.handle_client_sent(send->client, now_);
      } else if (const auto* transmit = std::get_if<Transmit>(&*action)) {
        frames_.push_back({transmit->frame.begin(), transmit->frame.end()});
      } else if (std::holds_alternative<Open>(*action)) {
        gateway_.handle_bus_opened(kBus, now_);
      } else if (const auto* close = std::get_if<Close>(&*action)) {
        closed_.insert(close->client);
      } else if (const auto* report = std::get_if<Report>(&*action)) {
        events_.push_back(report->event);
      }
    }
  }

  Instant now_{};
  Gateway gateway_;
  std::uint64_t last_client_ = 0;
  std::deque<ByteList> frames_;
  std::map<ClientId, std::deque<ByteList>> adus_;
  std::set<ClientId> closed_;
  std::vector<Event> events_;
};

/// An RTU frame to its device, and what comes back, on either side.
struct Example {
  std::string where;
  ByteList rtu_request;
  ByteList tcp_request;
  ByteList rtu_response;
  ByteList tcp_response;
};

// Where the manual prints no response, the device answers with MOONS' vendor exception 0x13, which
// must reach the client unchanged too.
inline ByteList vendor_exception(const ByteList& rtu_request) {
  return rtu_of(rtu_request[0], {static_cast<std::uint8_t>(rtu_request[1] | 0x80U), 0x13});
}

inline std::vector<Example> printed_pairs() {
  std::vector<Example> examples;
  for (const manuals::Transaction& transaction : manuals::load_transactions()) {
    const manuals::Pair& request = transaction.request;
    Example example{request.where(), request.rtu, request.tcp, {}, {}};
    if (transaction.response) {
      example.rtu_response = transaction.response->rtu;
      example.tcp_response = transaction.response->tcp;
    } else {
      example.rtu_response = vendor_exception(request.rtu);
      example.tcp_response = tcp_of(example.rtu_response);
    }
    examples.push_back(example);
  }
  return examples;
}

inline Example printed_pair(unsigned line) {
  const auto examples = printed_pairs();
  const auto found =
      std::ranges::find(examples, "moons-drives:" + std::to_string(line), &Example::where);
  if (found == examples.end()) {
    throw std::runtime_error("no pair at line " + std::to_string(line));
  }
  return *found;
}

inline void expect_exchange(Bench& bench, ClientId client, const Example& example) {
  bench.from_client(client, example.tcp_request);
  ASSERT_EQ(bench.next_frame(), example.rtu_request) << example.where;
  bench.advance(milliseconds(50));
  bench.from_line(example.rtu_response);
  EXPECT_EQ(bench.next_adu(client), example.tcp_response) << example.where;
}

/// Another client is served as if nothing had happened.
inline void expect_undisturbed(Bench& bench, ClientId other) {
  expect_exchange(bench, other, printed_pair(261));
  EXPECT_FALSE(bench.is_closed(other));
}

}  // namespace mbgate::gateway::printed

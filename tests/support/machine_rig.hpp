// SPDX-License-Identifier: Apache-2.0
// A Gateway on a bench: virtual time, clients and lines played by the test, every action kept.
#pragma once

#include <cstdio>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "report/text.hpp"
#include "support/gateway_harness.hpp"
#include "support/hex.hpp"

namespace mbgate::test {

using namespace std::chrono_literals;
using bus::Duration;
using bus::Instant;
using gateway::BusId;
using gateway::ClientId;
using gateway::ListenerId;
using gateway::Settings;

/// One routed listener, one bus at 19200 8E1 (t3.5 = 2.005 ms), units 1-247 to the same addresses.
/// No listening at the start, so that tests begin with an idle line.
inline Settings one_bus() {
  Settings settings;
  settings.listeners.emplace_back().name = "plant";
  auto& line = settings.buses.emplace_back();
  line.name = "line-a";
  line.line.device = "/dev/ttyS0";
  line.line.echo = false;
  line.listen_first = 0ms;
  line.timing.response_timeout = 100ms;
  line.timing.offline_after = 0;
  line.coalesce = false;
  auto& route = settings.routes.emplace_back();
  route.first_unit = route.first_address = 1;
  route.last_unit = 247;
  route.buses = {BusId{0}};
  return settings;
}

class MachineRig {
 public:
  explicit MachineRig(Settings settings = one_bus(), bool open_lines = true)
      : harness(std::move(settings), Instant{}) {
    drain();
    if (open_lines) {
      for (std::uint32_t bus = 0; bus < harness.settings().buses.size(); ++bus) {
        open_line(bus);
      }
      advance(5ms);  // more than t3.5
      opened.clear();
      events.clear();
    }
  }

  void connect(std::uint64_t client, std::string_view address = "192.0.2.1",
               std::uint32_t listener = 0, std::optional<Instant> waits_since = {},
               const routing::ClientRole& role = {}) {
    feed(gateway::ClientConnected{
        ClientId{client},
        {ListenerId{listener}, *routing::ClientAddress::parse(address), waits_since, role}});
  }
  void receive(std::uint64_t client, std::string_view bytes, std::size_t unread = 0) {
    feed(gateway::ClientBytes{ClientId{client}, unhex(bytes), unread});
  }
  void half_close(std::uint64_t client) { feed(gateway::ClientHalfClosed{ClientId{client}}); }
  /// `bytes`: read when it had gone.
  void disconnect(std::uint64_t client, std::string_view bytes = {}) {
    feed(gateway::ClientDisconnected{ClientId{client}, unhex(bytes)});
  }
  void confirm_sent(std::uint64_t client) { feed(gateway::ClientSent{ClientId{client}}); }
  void line(std::string_view bytes, std::uint32_t bus = 0) {
    feed(gateway::LineBytes{BusId{bus}, unhex(bytes)});
  }
  /// A device's answer: address and PDU; the CRC is added.
  void respond(std::string_view address_and_pdu, std::uint32_t bus = 0) {
    const auto bytes = unhex(address_and_pdu);
    const auto frame =
        modbus::encode_rtu(bytes[0], *modbus::Pdu::from(modbus::Bytes(bytes).subspan(1)));
    feed(gateway::LineBytes{BusId{bus}, {frame.data(), frame.size()}});
  }
  void lose_line(std::uint32_t bus = 0) { feed(gateway::LineLost{BusId{bus}}); }
  /// The far end of a connection closes it.
  void close_line(std::uint32_t bus = 0) { feed(gateway::LineLost{BusId{bus}, bus::Loss::closed}); }
  void open_line(std::uint32_t bus = 0) { feed(gateway::LineOpened{BusId{bus}}); }
  void reload(const Settings& settings) { feed(gateway::SettingsChanged{&settings}); }
  void clear_counters() { feed(gateway::ClearCountersAsked{}); }
  void shutdown() { feed(gateway::ShutdownAsked{}); }
  /// The process stands still.
  void stall(std::chrono::milliseconds duration) {
    harness.go_on(now() + duration);
    feed(gateway::Stalled{duration});
  }
  [[nodiscard]] Instant now() const { return harness.now(); }
  /// Lets time pass, stopping at every deadline on the way.
  void advance(Duration duration) {
    harness.advance(now() + duration, [this] { drain(); });
  }

  /// What went out since the last call, as hexadecimal text.
  std::vector<std::string> take_sent(std::uint64_t client) {
    return std::exchange(sent[client], {});
  }
  std::vector<std::string> take_transmitted(std::uint32_t bus = 0) {
    return std::exchange(transmitted[bus], {});
  }

  GatewayHarness harness;
  bool confirms = true;  ///< sockets take every answer at once
  std::map<std::uint64_t, std::vector<std::string>> sent;
  std::map<std::uint32_t, std::vector<std::string>> transmitted;
  std::map<std::uint32_t, std::vector<Instant>> transmitted_at;
  std::vector<Instant> opened;
  std::set<std::uint64_t> closed;
  std::set<std::uint64_t> paused;
  std::vector<std::string> events;
  unsigned shut = 0;
  bool finished = false;

  void take(const gateway::Send& action) {
    const auto client = static_cast<std::uint64_t>(action.client);
    sent[client].push_back(hex({action.adu.data(), action.adu.size()}));
    if (confirms) {
      harness.handle(gateway::ClientSent{action.client});
    }
  }
  void take(const gateway::Shut& /*action*/) { ++shut; }
  void take(const gateway::Look& action) { harness.handle(gateway::LineLooked{action.bus}); }
  void take(const gateway::Transmit& action) {
    const auto bus = static_cast<std::uint32_t>(action.bus);
    transmitted[bus].push_back(hex({action.frame.data(), action.frame.size()}));
    transmitted_at[bus].push_back(now());
  }
  void take(const gateway::Pause& action) {
    paused.insert(static_cast<std::uint64_t>(action.client));
  }
  void take(const gateway::Resume& action) {
    paused.erase(static_cast<std::uint64_t>(action.client));
  }
  void take(const gateway::Close& action) {
    closed.insert(static_cast<std::uint64_t>(action.client));
  }
  void take(const gateway::Open& /*action*/) { opened.push_back(now()); }
  void take(const gateway::Report& action) {
    events.push_back(report::to_text(action.event, harness.settings()));
  }
  void take(const gateway::Finished& /*action*/) { finished = true; }

 private:
  void drain() { harness.drain(*this); }
  void feed(const gateway::Input& input) {
    harness.handle(input);
    drain();
  }
};

/// A read of register 0, and a write of 1 to it, as MBAP in hexadecimal.
inline std::string read_request(unsigned transaction, unsigned unit = 1) {
  char text[64];
  std::snprintf(text, sizeof text, "%04X 0000 0006 %02X 03 0000 0001 ", transaction, unit);
  return text;
}

inline std::string write_request(unsigned transaction, unsigned unit = 1) {
  char text[64];
  std::snprintf(text, sizeof text, "%04X 0000 0006 %02X 06 0000 0001 ", transaction, unit);
  return text;
}

/// Strings of one line each, for EXPECT_THAT(..., ElementsAre(...)).
using Lines = std::vector<std::string>;

}  // namespace mbgate::test

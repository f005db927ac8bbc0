// SPDX-License-Identifier: Apache-2.0
// Settings that are read again, in another order and with less in them; and failsafe writes.
#include <algorithm>

#include "judge/drill.hpp"

namespace mbgate::judge {
namespace {

constexpr std::uint8_t kFirstUnit = 101;

// Of the second listener.
Id read_routed(Drill& drill, unsigned host, std::size_t station) {
  Client& client = drill.world().visit(1, host);
  Intent intent = drill.intent(Kind::read, 2 + station, request(3, kLiveFrom, 4));
  intent.codes = code(1) | code(10);
  intent.reads = Range{Table::holding_registers, kLiveFrom, 4};
  const Id id = drill.ask(client, std::move(intent), 300ms);
  client.leave();
  return id;
}

// The same, written down the other way round.
gateway::Settings reversed(const gateway::Settings& settings) {
  gateway::Settings other = settings;
  std::ranges::reverse(other.devices);
  std::ranges::reverse(other.guards);
  std::ranges::reverse(other.listeners);
  const std::size_t last = other.devices.size() - 1;
  for (routing::Route& route : other.routes) {
    route.device = last - *route.device;
    route.listener = routing::ListenerId{0};
  }
  for (routing::AccessRule& rule : other.rules) {
    for (std::size_t& device : rule.devices) {
      device = last - device;
    }
    for (routing::ListenerId& listener : rule.listeners) {
      listener = routing::ListenerId{0};
    }
  }
  return other;
}

void check_all(Drill& drill, const char* when) {
  const auto is = [&](const char* what, Id id, const char* must) {
    drill.expect((std::string(when) + "_" + what).c_str(), drill.outcome(id) == must,
                 drill.outcome(id));
  };
  Client& client = drill.visit(0);
  is("straight_0", drill.read(client, 0, 300ms), "ok");
  is("straight_1", drill.read(client, 1, 300ms), "ok");
  is("routed_0", read_routed(drill, 0, 0), "ok");
  is("routed_1", read_routed(drill, 0, 1), "ok");
  is("permitted", read_routed(drill, 1, 0), "ok");
  is("denied", read_routed(drill, 1, 1), "01");
  const Id owner = drill.write(client, 0, 300ms);
  is("owner", owner, "ok");
  Client& other = drill.visit(2);
  is("not_owner", drill.write(other, 0, 300ms), "06");
  is("any_writer", drill.write(other, 1, 300ms), "ok");
  other.leave();
  client.leave();
}

}  // namespace

void drill_reload(Drill& drill, bool trace) {
  gateway::Settings& settings = drill.plan().settings;
  settings.listeners.emplace_back().name = "routed";
  drill.plan().readers.resize(2);
  routing::AccessRule denies;
  denies.permits = false;
  denies.clients.push_back({"panel", networks_of({1}), {}});
  denies.devices = {1};
  denies.listeners = {routing::ListenerId{1}};
  settings.rules = {denies, routing::AccessRule{}};
  settings.guards[0].writer = gateway::WriterRule::first;
  settings.guards[0].writer_hold = 500ms;
  for (std::size_t at = 0; at < 2; ++at) {
    routing::Route route;
    route.listener = routing::ListenerId{1};
    route.first_unit = route.last_unit = low(kFirstUnit + static_cast<unsigned>(at));
    route.buses = {drive::BusId{0}};
    route.first_address = drill.plan().stations[at].address;
    route.device = at;
    settings.routes.push_back(route);
    Door door = drill.plan().doors[at];
    door.listener = 1;
    door.unit = route.first_unit;
    door.route = at;
    drill.plan().doors.push_back(door);
  }
  drill.begin(trace);
  const gateway::Settings before = drill.plan().settings;
  check_all(drill, "first");
  const auto sent = [&](const std::string& name) {
    std::uint64_t count = 0;
    for (const auto& it : drill.world().gateway().report_status(0s, drill.now()).devices) {
      count += it.name == name ? it.counters.transmissions : 0;
    }
    return count;
  };
  drill.equal("counted", sent("drive-1"), std::uint64_t{4});
  drill.world().change(reversed(before));
  drill.wait(1s);
  check_all(drill, "reversed");
  drill.equal("counted_on", sent("drive-1"), std::uint64_t{8});
  const auto status = drill.world().gateway().report_status(0s, drill.now());
  drill.expect("written_order", status.devices.front().name == "drive-2");
  // Without the second device and its route; it is an address like others then.
  gateway::Settings less = before;
  less.devices.pop_back();
  less.guards.pop_back();
  less.routes.pop_back();
  less.rules.clear();
  drill.world().change(less);
  drill.wait(1s);
  const Id nowhere = read_routed(drill, 0, 1);
  drill.expect("no_route", drill.outcome(nowhere) == "0A", drill.outcome(nowhere));
  drill.expect("no_route_told", std::ranges::any_of(drill.world().events(), [](const auto& it) {
                 return std::holds_alternative<gateway::UnitNotRouted>(it);
               }));
  const Id there = read_routed(drill, 0, 0);
  drill.expect("other_route", drill.outcome(there) == "ok", drill.outcome(there));
  drill.world().change(reversed(before));
  drill.wait(1s);
  check_all(drill, "again");
  gateway::Settings without = before;
  without.listeners.pop_back();
  without.routes.clear();
  without.rules.clear();
  Client& routed = drill.world().visit(1, 0);
  drill.world().change(without);
  drill.expect("listener_gone", !routed.is_connected());
  drill.world().change(before);
  drill.wait(1s);
  check_all(drill, "back");
}

// The client that wrote has gone, or is silent, or the gateway stops: its drive gets the write,
// once.
void drill_failsafe(Drill& drill, bool trace) {
  constexpr Duration kAgain = 2s;
  gateway::DeviceGuard& guard = drill.plan().settings.guards[0];
  const std::array<std::uint8_t, 5> write{6, 0, low(kFailsafeRegister), high(kFailsafeWord),
                                          low(kFailsafeWord)};
  guard.failsafe.push_back(*modbus::Request::parse(*modbus::Pdu::from(write)));
  guard.failsafe_grace = drill.random().duration(100ms, 1s);
  const bool by_silence = drill.random().chance(500);
  guard.quiet = by_silence ? drill.random().duration(1s, 3s) : 0ms;
  guard.failsafe_on_exit = true;
  drill.timing(0).offline_after = 0;
  drill.begin(trace);
  Client& client = drill.visit(0);
  drill.read(client, 0, 4s);
  drill.equal("not_armed", drill.transmissions().size(), std::size_t{1});
  drill.write(client, 0, 500ms);
  const Instant asked = drill.ledger().asked.back().given;
  drill.transmissions();
  const Instant left = drill.now();
  if (!by_silence) {
    client.leave();
  }
  drill.wait(4s);
  const auto sent = drill.transmissions();
  drill.equal("failsafe", sent.size(), std::size_t{1});
  if (sent.empty()) {
    return;
  }
  const Instant due = by_silence ? asked + guard.quiet : left;
  drill.between("failsafe_due", drill.ledger().sent[sent[0]].begin - due, 0ms,
                guard.failsafe_grace + 60ms);
  const auto reason = by_silence ? gateway::FailsafeReason::silent : gateway::FailsafeReason::gone;
  const auto news = [&](gateway::FailsafeOutcome outcome,
                        std::optional<gateway::FailsafeReason> of) {
    return std::ranges::count_if(drill.world().events(), [&](const gateway::Event& event) {
      const auto* it = std::get_if<gateway::FailsafeNews>(&event);
      return it != nullptr && it->outcome == outcome && (!of || it->reason == *of);
    });
  };
  drill.equal("failsafe_told", news(gateway::FailsafeOutcome::acknowledged, reason),
              std::ptrdiff_t{1});
  // A drive without supply gets it later, again and again, until it has it or its client is back.
  Client& other = drill.visit(0);
  drill.write(other, 0, 200ms);
  drill.world().habits_of(0).deaf = 1000;
  drill.transmissions();
  other.leave();
  drill.wait(guard.quiet + guard.failsafe_grace + 4 * kAgain);
  const std::size_t tries = drill.transmissions().size();
  drill.expect("failsafe_again", tries >= 3, std::to_string(tries));
  drill.equal("failsafe_waits", news(gateway::FailsafeOutcome::waits, {}), std::ptrdiff_t{1});
  drill.world().habits_of(0).deaf = 0;
  drill.wait(2 * kAgain);
  drill.equal("failsafe_in_the_end", news(gateway::FailsafeOutcome::acknowledged, {}),
              std::ptrdiff_t{2});
  Client& last = drill.visit(0);
  drill.write(last, 0, 200ms);
  drill.transmissions();
  drill.world().shut_down();
  drill.equal("failsafe_on_exit", drill.transmissions().size(), std::size_t{1});
}

}  // namespace mbgate::judge

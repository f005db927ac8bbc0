// SPDX-License-Identifier: Apache-2.0
#include "judge/drill.hpp"

#include <algorithm>
#include <array>

namespace mbgate::judge {

Drill::Drill(std::uint64_t seed, unsigned drives) : random_(seed ^ kDrillsChance) {
  plan_.seed = seed;
  auto& bus = plan_.settings.buses.emplace_back();
  bus.name = "line";
  bus.line.device = "/dev/ttyS0";
  bus.line.framing = random_.one_of({bus::Framing::rtu, bus::Framing::rtu, bus::Framing::ascii});
  bus.line.baud = modbus::Baud{random_.one_of<std::uint32_t>({9600, 19200, 57600, 115200})};
  bus.listen_first = 0ms;
  bus.settle = random_.chance(300) ? random_.duration(1ms, 20ms) : 0ms;
  plan_.lines.emplace_back().kind = bus::LineKind::uart;
  plan_.lines.back().echoes = random_.chance(300);
  bus.line.echo = plan_.lines.back().echoes;
  auto& listener = plan_.settings.listeners.emplace_back();
  listener.name = "clients";
  listener.bus = drive::BusId{0};
  unsigned address = 0;
  for (std::size_t at = 0; at < drives; ++at) {
    address += random_.between(1U, 5U);
    auto& device = plan_.settings.devices.emplace_back();
    device.name = "drive-" + std::to_string(at + 1);
    device.bus = drive::BusId{0};
    device.address = low(address);
    draw_timing(device.timing, false, random_);
    device.timing.retry_writes = false;
    device.profile.stops.push_back({Table::holding_registers, kStopRegister, 0xF000, 0x5000});
    device.word_order = drive::WordOrder::big;
    plan_.stations.push_back({0, low(address), at, {at}});
    plan_.drives.emplace_back().habits.quick = 2ms;
    Door door;
    door.unit = low(address);
    door.station = at;
    plan_.doors.push_back(door);
  }
  plan_.readers.resize(1);
  plan_.writers.resize(drives);
  plan_.settings.guards.resize(drives);
}

void Drill::begin(bool trace) {
  set_deadlines(plan_);
  world_.emplace(plan_, trace);
  judge_.emplace(*world_);
  rules_.emplace(*world_, *judge_);
  world_->be_watched_by(*rules_);
  wait(1s);
}

Id Drill::ask(Client& client, Intent intent, Duration patience) {
  const Id id = client.write(std::move(intent));
  wait(patience);
  return id;
}

Intent Drill::intent(Kind kind, std::size_t door, Octets pdu) {
  Intent intent;
  intent.kind = kind;
  intent.door = door;
  intent.unit = plan_.doors[door].unit;
  intent.station = plan_.doors[door].station;
  intent.whole = true;
  intent.pdu = intent.sent = std::move(pdu);
  intent.writes = cells_of(intent.pdu);
  return intent;
}

Id Drill::read(Client& client, std::size_t door, Duration patience, unsigned count) {
  Intent it = intent(Kind::read, door, request(3, kLiveFrom, count));
  it.reads = Range{Table::holding_registers, kLiveFrom, count};
  return ask(client, std::move(it), patience);
}

Id Drill::write(Client& client, std::size_t door, Duration patience) {
  return ask(client, intent(Kind::write, door, request(6, 1, ++words_)), patience);
}

Id Drill::stop(Client& client, std::size_t door, std::uint16_t word, Duration patience) {
  return ask(client, intent(Kind::stop, door, request(6, kStopRegister, word)), patience);
}

std::string Drill::outcome(Id id) {
  const Asked& asked = ledger().asked[id];
  return asked.answers == 0                                    ? ""
         : asked.answer.size() == 2 && asked.answer[0] >= 0x80 ? hex(Bytes(asked.answer).subspan(1))
                                                               : "ok";
}

std::vector<Id> Drill::transmissions() {
  std::vector<Id> sent;
  for (; seen_ < ledger().sent.size(); ++seen_) {
    sent.push_back(static_cast<Id>(seen_));
  }
  return sent;
}

gateway::BusStatus Drill::bus() { return world_->gateway().report_status(0s, now()).buses.front(); }

gateway::DeviceStatus Drill::device(std::size_t station) {
  return world_->gateway().report_status(0s, now()).devices[station];
}

std::size_t Drill::notices(bus::DeviceNotice::Kind kind, std::size_t station) {
  return static_cast<std::size_t>(
      std::ranges::count_if(world_->events(), [&](const gateway::Event& event) {
        const auto* news = std::get_if<gateway::DeviceNews>(&event);
        return news != nullptr && news->notice.kind == kind &&
               news->notice.address == plan_.stations[station].address;
      }));
}

Duration Drill::longest(std::size_t station) {
  const drive::DeviceTiming& timing = plan_.timing_of(plan_.stations[station]);
  const auto& bus = plan_.bus(0);
  return WireTimes(bus.line).of(bus.line.framing == bus::Framing::ascii ? 17 : 8) +
         timing.response_wait + timing.response_timeout;
}

void Drill::expect(const char* what, bool is_so, const std::string& text) {
  if (!is_so) {
    world_->report().violation("drill_" + std::string(what), text);
  }
}

void Drill::between(const char* what, Duration is, Duration least, Duration most) {
  expect(what, is >= least && is <= most,
         std::to_string(is / 1us) + " us, must be " + std::to_string(least / 1us) + " to " +
             std::to_string(most / 1us));
}

world::Report Drill::end() {
  world_->shut_down();
  judge_->check_end();
  return world_->report();
}

world::Report drill(std::uint64_t seed, bool trace) {
  constexpr std::array kDrills{drill_silence,  drill_damage,     drill_lateness,   drill_hold,
                               drill_seconds,  drill_room,       drill_turns,      drill_sharing,
                               drill_quiet,    drill_stop_first, drill_stop_fails, drill_reload,
                               drill_failsafe, drill_noise,      drill_misfits,    drill_stranger,
                               drill_crawl,    drill_old_echo};
  Drill drill(seed, 2);
  kDrills.at(seed % kDrills.size())(drill, trace);
  return drill.end();
}

}  // namespace mbgate::judge

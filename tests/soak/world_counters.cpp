// SPDX-License-Identifier: Apache-2.0
// At the end the status unit must say what was seen here (src/gateway/status_unit.hpp has
// the registers). A transmission that is to be answered was answered, was not in time, came damaged
// or was something else; which of these it was depends on the gateway alone, unless nothing came.
#include <algorithm>

#include "soak/world.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr std::uint16_t kBusesAt = 1000;
constexpr std::uint16_t kBusSize = 64;

std::uint64_t word_at(const PduBytes& pdu, std::size_t place) {
  return pdu.size() < 2 + 2 * place + 2 ? 0 : modbus::load_be16(pdu, 2 + 2 * place);
}

std::uint64_t long_at(const PduBytes& pdu, std::size_t place) {
  return (word_at(pdu, place) << 16U) | word_at(pdu, place + 1);
}

}  // namespace

void World::check_counters() {
  if (plan_.silence) {
    return;  // failsafe writes may be sent just now
  }
  Client& client = clients_.emplace_back(Manners{}, tools_);
  client.end_asking();
  check_head(client);
  for (std::size_t bus = 0; bus < buses_.size(); ++bus) {
    check_bus(client, bus);
  }
  for (std::size_t device = 0; device < devices_.size(); ++device) {
    check_device(client, device);
  }
}

const PduBytes& World::own_registers(Client& client, std::size_t first, std::size_t count) {
  client.connect();
  client.write(
      Asking::own_read(static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(count)));
  run_until(schedule_.now() + 10ms);
  return oracle_.own_answer();
}

void World::compare(const std::string& what, std::uint64_t shown, std::uint64_t least,
                    std::uint64_t most) {
  const bool is_too_few = shown < least && !counters_cleared_;
  if (is_too_few || shown > most) {
    oracle_.violation("counter", what + " " + std::to_string(shown) + ", seen " +
                                     std::to_string(least) + " to " + std::to_string(most));
  }
}

void World::compare_ends(const std::string& name, std::uint64_t responses, std::uint64_t timeouts,
                         std::uint64_t bad_crcs, const BusCount& count) {
  const std::uint64_t most = count.asking + count.excused;
  compare(name + ": responses, timeouts and bad CRCs", responses + timeouts + bad_crcs,
          count.silent + count.damaged, most);
  compare(name + ": timeouts", timeouts, count.silent, most - std::min(most, count.damaged));
  compare(name + ": bad CRCs", bad_crcs, count.damaged, most - std::min(most, count.silent));
}

void World::check_head(Client& client) {
  const PduBytes& pdu = own_registers(client, 0, 12);
  const auto connected = static_cast<std::uint64_t>(
      std::ranges::count_if(clients_, [](const Client& it) { return it.is_connected(); }));
  compare("buses", word_at(pdu, 1), buses_.size());
  const auto present = std::ranges::count(plan_.absent.devices, false);
  compare("devices", word_at(pdu, 2), static_cast<std::uint64_t>(present));
  compare("clients", word_at(pdu, 3), connected);
  compare("requests", long_at(pdu, 6), oracle_.accepted() - oracle_.perhaps_accepted(),
          oracle_.accepted());
  compare("framing lost", long_at(pdu, 10), 0, report_.framing_lost);
}

void World::check_bus(Client& client, std::size_t bus) {
  const std::string& name = plan_.settings.buses[bus].name;
  const PduBytes& pdu = own_registers(
      client, kBusesAt + kBusSize * *reloads_.arrangement().place_of_bus(bus), kBusSize);
  const BusCount& count = oracle_.count(bus);
  const std::uint64_t responses = long_at(pdu, 4);
  compare(name + ": open", word_at(pdu, 0), 1);
  compare(name + ": waiting", word_at(pdu, 1), 0);
  compare(name + ": transmissions", long_at(pdu, 2), count.transmissions);
  compare(name + ": exceptions", long_at(pdu, 6), 0, responses);
  compare_ends(name, responses, long_at(pdu, 8), long_at(pdu, 10), count);
  // What an adapter hands over late, an echo may seem to begin with; what it has when its line is
  // lost never comes, and what it has when a stop cuts the wait belongs to the echo of that.
  const std::uint64_t unseen = std::min(count.spoilt_echoes, count.losses + count.stops);
  compare(name + ": echo mismatches", long_at(pdu, 18), count.spoilt_echoes - unseen,
          count.transmissions);
  compare(name + ": late", long_at(pdu, 30), 0, count.transmissions);
  compare(name + ": losses", long_at(pdu, 24), count.losses);
  compare(name + ": broadcasts", long_at(pdu, 28), count.broadcasts);
  compare(name + ": stops", long_at(pdu, 42), count.stops);
}

void World::check_device(Client& client, std::size_t index) {
  const drive::Device& device = plan_.settings.devices[index];
  const auto bus = static_cast<std::size_t>(device.bus);
  const auto place = reloads_.arrangement().place_of_device(index);
  if (!place) {
    return;
  }
  const PduBytes& pdu = own_registers(client, kDevicesAt + kDeviceSize * *place, kDeviceSize);
  const BusCount& count = oracle_.count(bus, device.address);
  compare(device.name + ": bus", word_at(pdu, 0), *reloads_.arrangement().place_of_bus(bus) + 1);
  compare(device.name + ": address", word_at(pdu, 1), device.address);
  // What is written when the last client has gone nothing comes after: it may have been cut by the
  // next one, or been taken for answered by an echo.
  const bool is_watched =
      index < plan_.settings.guards.size() && !plan_.settings.guards[index].failsafe.empty();
  if (!is_watched) {
    compare(device.name + ": state", word_at(pdu, 2), 1);
    compare(device.name + ": unanswered in a row", word_at(pdu, 3), 0);
    compare(device.name + ": offline", word_at(pdu, 18), 0);
  }
  compare(device.name + ": transmissions", long_at(pdu, 4), count.transmissions);
  compare(device.name + ": exceptions", long_at(pdu, 8), 0, long_at(pdu, 6));
  compare_ends(device.name, long_at(pdu, 6), long_at(pdu, 10), long_at(pdu, 12), count);
  compare(device.name + ": late", long_at(pdu, 14), 0, count.transmissions);
}

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
// The parts of a bus. Each part owns its data, and none knows the others. What decides (Scheduler)
// only reads them, and so does whoever shows a bus. Classes that act (Bus, Dispatch, Outcomes,
// JobEnds) change them.
#pragma once

#include <algorithm>
#include <span>

#include "bus/action_queue.hpp"
#include "bus/bus_action.hpp"
#include "bus/health/device_table.hpp"
#include "bus/health/probes.hpp"
#include "bus/line_discipline.hpp"
#include "bus/link_state.hpp"
#include "bus/queue/bus_queue.hpp"
#include "bus/queue/fairness.hpp"
#include "bus/queue/stop_lane.hpp"
#include "bus/transmission/transmission.hpp"

namespace mbgate::bus {

struct Parts {
  Parts(const BusSettings& in_force, std::span<const drive::Device> known)
      : settings(in_force),
        devices(in_force, known),
        line(settings, counters),
        queue(in_force.queue),
        transmissions(most_in_flight()),
        probes(settings, devices),
        link(in_force.reopen_min) {}
  Parts(const Parts&) = delete;  // some refer to others
  Parts& operator=(const Parts&) = delete;

  /// New settings, or other devices, on the same line. Returns the addresses with another device.
  Addresses update(const BusSettings& in_force, std::span<const drive::Device> known) {
    settings = in_force;
    const Addresses others = devices.update(settings, known);
    acknowledged.forget_all();
    line.update();
    queue.set_limit(settings.queue);
    transmissions.set_room(most_in_flight());
    return others;
  }

  /// Are devices held in quarantine? Not where transaction identifiers tell late answers apart.
  [[nodiscard]] bool quarantines() const { return !settings.has_identifiers(); }
  /// Does a Modbus TCP server say that it did not reach the device? Then the device has not
  /// answered.
  [[nodiscard]] bool is_unreached(const modbus::Pdu& response) const {
    return settings.line.framing == Framing::tcp && response.is_unreached();
  }
  /// Requests that wait, stops among them.
  [[nodiscard]] std::size_t waiting() const { return queue.size() + stops.size(); }
  /// The client address of which the most requests wait for the line, and not for their device.
  [[nodiscard]] std::optional<BusQueue::Most> most_waiting(Instant now) const {
    Addresses held;
    for (std::size_t address = 0; address < kAddresses; ++address) {
      const auto number = static_cast<std::uint8_t>(address);
      const DeviceEntry& entry = devices[number];
      held[address] =
          entry.health.is_offline() || entry.free_at > now || held_back(number, now) > Duration{0};
    }
    return queue.most_waiting(held);
  }
  /// How long the device at the address is still left alone because it owes an answer.
  [[nodiscard]] Duration held_back(std::uint8_t address, Instant now) const {
    const DeviceEntry& entry = devices[address];
    const Instant until = entry.hold.until(entry.in_force());
    return quarantines() && until > now ? until - now : Duration{0};
  }
  /// A device behind a line that is not open is not answering.
  [[nodiscard]] DeviceState state_of(std::uint8_t address) const {
    const DeviceState state = devices[address].health.state();
    return state == DeviceState::answering && !link.serves() ? DeviceState::line_not_open : state;
  }

  BusSettings settings;
  DeviceTable devices;
  BusCounters counters;
  LineDiscipline line;
  BusQueue queue;
  Transmissions transmissions;
  StopLane stops;
  AcknowledgedStops acknowledged;
  LastSent last_sent;
  Payback payback;
  Probes probes;
  AdapterWatch adapter;
  LinkState link;
  bool stopping = false;
  bool is_traced = false;  ///< each transmission is told, and what became of it
  Instant pumped_at;       ///< when it was last decided what is sent next
  ActionQueue<BusAction> actions;

 private:
  [[nodiscard]] std::size_t most_in_flight() const {
    return settings.line.framing == Framing::tcp ? settings.outstanding : 1;
  }
};

}  // namespace mbgate::bus

// SPDX-License-Identifier: Apache-2.0
// Drives that work in order and slowly, whatever is asked of them meanwhile; late answers, and
// second ones.
#include <algorithm>

#include "soak/serial_wire.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

// What it does it does when its turn has come: so long nothing of it is done.
bool SerialWire::waits_its_turn(const SoakDevice& device, const Flight& flight) {
  const Duration service = ways_of(device).service;
  if (is_calm_ || service == Duration{0}) {
    return false;
  }
  around_.report.fault("slow_drive");
  Instant& free = works_until_[device.settings().address];
  free = std::max(free, around_.schedule.now()) +
         slow_random_.duration(service * 9 / 10, service * 11 / 10);
  around_.schedule.at(free, [this, epoch = epoch_, number = flight.number] {
    const Flight* asked = around_.oracle.flight(number);
    SoakDevice* worker = asked == nullptr ? nullptr : device_at(asked->address);
    if (epoch == epoch_ && worker != nullptr && !worker->is_dead(around_.schedule.now())) {
      answer(*worker, *asked, *modbus::Pdu::from(asked->pdu));
    }
  });
  return true;
}

// Of another drive with its address, or of a repeater.
void SerialWire::answer_again(const SoakDevice& device, const Flight& flight, const Frame& frame,
                              Instant begin) {
  const Ways& ways = ways_of(device);
  if (is_calm_ || ways.second == 0 || !slow_random_.chance(ways.second)) {
    return;
  }
  around_.report.fault("second_answer");
  Content content{device.settings().address, 1, 0, true, flight.number};
  content.is_second = true;
  const Instant again = begin + timing_.of(frame.size()) + silence_ +
                        slow_random_.duration(ways.second_from, ways.second_to);
  say(frame, again, Chunks::usual, content);
}

// All of it is there when the quarantine ends, often only just; or later, in plans of that kind and
// where its device still had to say something else.
void SerialWire::answer_late(SoakDevice& device, const Flight& flight, const Frame& frame,
                             Instant begin) {
  const Duration held = around_.plan.adapters[bus_] == AdapterKind::uart ? 0ms : kAdapterHolds;
  const Duration length = timing_.of(frame.size()) + 1ms + held;
  Instant last = flight.quarantine_until - length;
  if (around_.plan.beyond) {
    last += 2 * (flight.quarantine_until - flight.end);
  }
  const Instant first = std::max(begin, flight.deadline - length);
  last = std::max(first, last);
  Duration after = around_.random.duration(0us, last - first);
  if (!around_.plan.beyond && around_.random.chance(600)) {
    const Duration near = std::min<Duration>(last - first, around_.random.duration(0us, 3ms));
    after = around_.random.chance(300) ? near : last - first - near;
  }
  const Instant at = first + after;
  if (straddles(flight, frame, at)) {
    return;
  }
  const bool pauses = happens_to_echo(rates_.late_pieces, "late_pieces");
  const Duration paused = pauses ? last - at : Duration{0};
  auto& busy = talks_until_[device.settings().address];
  busy = std::max(busy, at + length + paused);
  say(frame, at, pauses ? Chunks::paused : Chunks::usual,
      {device.settings().address, 1, 0, true, flight.number, 0, paused});
}

// Its drive does not stop.
std::optional<std::uint8_t> SerialWire::refusal_of(const Flight& flight) {
  if (!flight.is_stop || !flight.expects_answer ||
      !happens_rarely(rates_.refuses_stop, "stop_refused")) {
    return std::nullopt;
  }
  return kStopRefusals.at(rare_random_.below(kStopRefusals.size()));
}

const Ways& SerialWire::ways_of(const SoakDevice& device) const {
  const auto& all = around_.devices;
  const auto at = std::ranges::find_if(all, [&](const auto& it) { return &it == &device; });
  return around_.plan.ways[static_cast<std::size_t>(at - all.begin())];
}

}  // namespace mbgate::soak

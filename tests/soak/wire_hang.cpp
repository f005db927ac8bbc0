// SPDX-License-Identifier: Apache-2.0
// An adapter that hangs: it takes what is transmitted, and nothing at all is heard until it is
// closed and opened again. Some still transmit it, others do not. And devices that are silent for
// long.
#include <algorithm>

#include "soak/serial_wire.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

// Between frames, so that none is heard in part.
void SerialWire::begin_hang() {
  if (rates_.hangs_every == Duration{0}) {
    return;
  }
  later(rates_.hangs_every, &SerialWire::begin_hang);
  const bool may_hang = around_.plan.kinds[bus_] != bus::LineKind::virtual_line;
  if (may_hang && !is_hung() && !is_busy() && !echo_) {
    around_.report.fault("adapter_hangs");
    deaf_until_ = Instant::max();
    straddling_.reset();
    swallows_ = echo_random_.chance(500);
  }
}

bool SerialWire::is_hung() const { return deaf_until_ == Instant::max(); }

// Opened again, some hang as before.
bool SerialWire::goes_on_hanging() {
  return around_.plan.kinds[bus_] != bus::LineKind::virtual_line && echo_random_.chance(400);
}

// Again and again, as long as things go wrong.
void SerialWire::put_to_sleep(std::size_t place) {
  SoakDevice& device = *devices_[place];
  if (rates_.sleeps == Duration{0} || !is_sleeper(device)) {
    return;
  }
  const Duration asleep = around_.random.duration(rates_.sleeps / 4, rates_.sleeps);
  const Duration awake = around_.random.duration(0ms, rates_.sleeps / 2);
  around_.report.fault("sleep");
  device.die_until(around_.schedule.now() + asleep);
  around_.schedule.after(asleep + awake, [this, place] { put_to_sleep(place); });
}

bool SerialWire::is_sleeper(const SoakDevice& device) const {
  const auto& all = around_.devices;
  const auto at = std::ranges::find_if(all, [&](const auto& it) { return &it == &device; });
  return around_.plan.sleepers[static_cast<std::size_t>(at - all.begin())];
}

// What began before that is not heard.
void SerialWire::end_hang() { deaf_until_ = is_hung() ? around_.schedule.now() : deaf_until_; }

}  // namespace mbgate::soak

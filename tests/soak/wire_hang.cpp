// SPDX-License-Identifier: Apache-2.0
// An adapter that hangs: it takes what is transmitted, and nothing at all is heard until it is
// closed and opened again. Some still transmit it, others do not.
#include "soak/serial_wire.hpp"

namespace mbgate::soak {

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
    swallows_ = echo_random_.chance(500);
  }
}

bool SerialWire::is_hung() const { return deaf_until_ == Instant::max(); }

// Opened again, some hang as before.
bool SerialWire::goes_on_hanging() {
  return around_.plan.kinds[bus_] != bus::LineKind::virtual_line && echo_random_.chance(400);
}

// What began before that is not heard.
void SerialWire::end_hang() { deaf_until_ = is_hung() ? around_.schedule.now() : deaf_until_; }

}  // namespace mbgate::soak

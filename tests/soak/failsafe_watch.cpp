// SPDX-License-Identifier: Apache-2.0
#include "soak/failsafe_watch.hpp"

#include <algorithm>

#include "soak/specification.hpp"

namespace mbgate::soak {

bool is_failsafe(const PduBytes& pdu) {
  constexpr std::size_t kSingle = 5;
  if (pdu.size() != kSingle || pdu.front() != 0x06) {
    return false;
  }
  const unsigned address = spec::word_at(pdu, 1);
  return address == kFailsafeRegister || address == kFailsafeRegister + 1U ||
         (address == kStopRegister && spec::word_at(pdu, 3) == kFailsafeStop);
}

void FailsafeWatch::asked(std::size_t device, const Asked& asked, Instant now) {
  Device& at = devices_[device];
  if (asked.changes() && at.writer != asked.client) {
    at.writer.reset();  // perhaps it is that one by now
  }
  at.asked = at.writer == asked.client ? now : at.asked;
}

void FailsafeWatch::wrote(std::size_t device, ClientId client, Instant now) {
  devices_[device].writer = client;
  devices_[device].asked = now;
}

void FailsafeWatch::forget_writers() {
  std::ranges::for_each(devices_, [](Device& it) { it.writer.reset(); });
}

void FailsafeWatch::gone(ClientId client) {
  for (Device& it : devices_) {
    it.writer = it.writer == client ? std::nullopt : it.writer;
  }
}

// Which clients count may be said by the settings, and how long they may be silent. Whom rules let
// write what is not asked here.
bool FailsafeWatch::is_unwanted(std::size_t device, Instant now) const {
  const gateway::DeviceGuard& guard = plan_.settings.guards[device];
  const Device& at = devices_[device];
  return at.writer.has_value() && guard.failsafe_clients.networks.empty() &&
         guard.writer != gateway::WriterRule::listed && plan_.rules.empty() &&
         (guard.quiet == Duration{0} || now < at.asked + guard.quiet);
}

std::optional<PduBytes> FailsafeWatch::missing(std::size_t device, Instant since) const {
  const Device& at = devices_[device];
  const gateway::DeviceGuard& guard = plan_.settings.guards[device];
  if (at.written == Instant::min() || at.written < since ||
      !guard.failsafe_clients.networks.empty()) {
    return std::nullopt;
  }
  for (const PduBytes& write : plan_.failsafe[device]) {
    const auto done = at.done.find(write);
    if (done == at.done.end() || done->second < at.written) {
      return write;
    }
  }
  return std::nullopt;
}

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
// Who may write to the devices of one seed, and whose turn weighs more.
#include "soak/pdus.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

void draw_failsafe(SoakPlan& plan, std::size_t device, Random& random) {
  gateway::DeviceGuard& guard = plan.settings.guards[device];
  std::vector<PduBytes>& writes = plan.failsafe[device];
  writes = {fields(6, kFailsafeRegister, 0xFA11)};
  if (random.chance(500)) {
    writes.push_back(random.chance(500) ? fields(6, kFailsafeRegister + 1, 0xFA12)
                                        : fields(6, kStopRegister, kFailsafeStop));
  }
  guard.quiet = plan.silence && random.chance(700) ? random.duration(100ms, 3s) : 0ms;
  guard.failsafe.clear();
  for (const PduBytes& write : writes) {
    guard.failsafe.push_back(*modbus::Request::parse(*modbus::Pdu::from(write)));
  }
}

void draw_weights(SoakPlan& plan, Random& random) {
  plan.settings.weights.clear();
  for (unsigned host = 0; host < kMostHosts; ++host) {
    if (random.chance(plan.theme == Theme::busy_line ? 600 : 200)) {
      plan.settings.weights.push_back({network_of(host), random.between(2U, 5U)});
    }
  }
}

void draw_guards(SoakPlan& plan, Random& random) {
  auto& settings = plan.settings;
  const bool are_any = random.chance(500);
  plan.silence = are_any && random.chance(250);
  for (gateway::ListenerSettings& listener : settings.listeners) {
    listener.ordered = listener.ordered && !plan.silence;
  }
  for (std::size_t device = 0; device < settings.devices.size(); ++device) {
    gateway::DeviceGuard& guard = settings.guards.emplace_back();
    std::vector<unsigned>& listed = plan.writers.emplace_back();
    plan.failsafe.emplace_back();
    if (!are_any) {
      continue;
    }
    if (random.chance(300)) {
      draw_failsafe(plan, device, random);
    }
    if (random.chance(200)) {
      guard.writer = gateway::WriterRule::first;
      guard.writer_hold = random.duration(200ms, 5s);
    } else if (random.chance(150)) {
      guard.writer = gateway::WriterRule::listed;
      for (unsigned host = 0; host < kMostHosts; ++host) {
        if (random.chance(600)) {
          listed.push_back(host);
          guard.writers.networks.push_back(network_of(host));
        }
      }
    }
  }
  draw_weights(plan, random);
}

}  // namespace mbgate::soak

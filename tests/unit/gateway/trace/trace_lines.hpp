// SPDX-License-Identifier: Apache-2.0
// Records of a trace as lines, for tests.
#pragma once

#include <string>

#include "gateway/trace/trace_record.hpp"
#include "support/machine_rig.hpp"

namespace mbgate::test {

inline std::string text(const gateway::WireTrace& wire) {
  std::string all = " / " + wire.bus + " " + wire.device + "> " + hex(wire.frame) + " <";
  for (const gateway::HeardBytes& part : wire.heard) {
    all += " " + hex(part.bytes);
  }
  return all + " " + report::to_text(wire.outcome);
}

inline std::string text(const gateway::TraceRecord& record) {
  std::string all = record.asked ? hex(record.asked->request) + " =" : "=";
  if (record.asked && record.asked->answer) {
    all += " " + hex(*record.asked->answer);
  }
  for (const gateway::WireTrace& wire : record.wire) {
    all += text(wire);
  }
  return all;
}

inline Settings one_axis() {
  Settings settings = one_bus();
  settings.buses[0].timing.retries = 1;
  settings.buses[0].coalesce = true;
  settings.devices = {{"axis", BusId{0}, 1, settings.buses[0].timing}};
  return settings;
}

/// What has come to its end.
inline Lines taken_lines(MachineRig& rig) {
  Lines all;
  for (const gateway::TraceRecord& record : rig.harness.gateway().take_trace(rig.now()).records) {
    all.push_back(text(record));
  }
  return all;
}

}  // namespace mbgate::test

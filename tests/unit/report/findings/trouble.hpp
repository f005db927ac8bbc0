// SPDX-License-Identifier: Apache-2.0
// A plant of two devices in trouble, and what its status says of it.
#pragma once

#include <gmock/gmock.h>

#include "report/findings/diagnosis.hpp"
#include "support/machine_rig.hpp"

namespace mbgate::test {

inline constexpr auto kAnswerOfAxis = "01 03 02 12 34";

inline Settings troubled_plant() {
  Settings settings = one_bus();
  settings.listeners[0].pipeline = 64;
  settings.buses[0].timing.retries = 0;
  settings.devices = {{"axis", BusId{0}, 1, settings.buses[0].timing},
                      {"lift", BusId{0}, 2, settings.buses[0].timing}};
  return settings;
}

/// What a serial line on which nothing has ever answered is to be examined for.
inline constexpr auto kCausesOfNoAnswer =
    "power; the cable and its plug; A and B; whether `device` is the port of this line; unit "
    "addresses; the drives' setting, here 19200 baud 8E1; RTU or ASCII (`mode`); how the direction "
    "is switched (`rs485`)";

class Trouble {
 public:
  explicit Trouble(const Settings& settings = troubled_plant()) : rig(settings) {
    rig.connect(1, "192.0.2.7");
  }
  [[nodiscard]] gateway::StatusReport report(bool with_clients = true) {
    return rig.harness.gateway().report_status(60s, rig.now(), with_clients);
  }
  [[nodiscard]] Lines diagnoses(bool with_clients = true) {
    Lines all;
    for (const auto& it : report::diagnose(report(with_clients))) {
      all.push_back(it.subject + ": " + it.finding + " | " + it.evidence + " | " + it.look_at);
    }
    return all;
  }
  /// `heard` comes, and after a silence the answer.
  void read(std::string_view heard, std::string_view answer = kAnswerOfAxis) {
    rig.receive(1, read_request(1));
    rig.advance(10ms);
    if (!heard.empty()) {
      rig.line(heard);
      rig.advance(10ms);
    }
    rig.respond(answer);
    rig.advance(20ms);
  }
  void ask_and_answer(unsigned unit) {
    rig.receive(1, read_request(1, unit));
    rig.advance(10ms);
    rig.respond("0" + std::to_string(unit) + " 03 02 12 34");
    rig.advance(20ms);
  }
  void ask_in_vain(int times, unsigned unit) {
    for (int at = 0; at < times; ++at) {
      rig.receive(1, read_request(1, unit));
      rig.advance(430ms);
    }
  }
  void read_in_vain(int times, std::string_view heard = "") {
    for (int at = 0; at < times; ++at) {
      rig.receive(1, read_request(1));
      rig.advance(30ms);
      rig.line(heard);
      rig.advance(400ms);
    }
  }
  void write_value() { rig.receive(1, "0001 0000 000B 01 10 001E 0002 04 0001 0002"); }
  /// The word order register holds this.
  void tell_order(std::string_view value) {
    rig.advance(10ms);
    rig.respond("01 03 02 " + std::string(value));
    rig.advance(10ms);
  }

  MachineRig rig;
};

}  // namespace mbgate::test

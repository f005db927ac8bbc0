// SPDX-License-Identifier: Apache-2.0
// Plants in which all is well, for as long as it takes to be sure: lines of any speed with drives
// of four makers, and clients that poll them.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>

#include "gateway/status/diagnosis.hpp"
#include "simulation/polling.hpp"

namespace mbgate::test {

struct HealthyPlant {
  const char* name;
  std::uint32_t baud = 19200;
  bus::Framing framing = bus::Framing::rtu;
  unsigned drives = 4;
  unsigned clients = 2;
  /// How long a client thinks, about; with `load` only at first.
  Duration thinks = 200ms;
  /// The clients think shorter and shorter until the line is busy for about so many percent of the
  /// time.
  unsigned load = 0;
  /// The first client asks again at once, and the line is busy all the time.
  bool hurries = false;
  /// Now and then one answer is lost or damaged, counters are cleared, settings reloaded.
  bool is_disturbed = false;
  Duration drives_take{0};  ///< other than 0: until each answer
  bool echo = false;        ///< known to the settings
  Duration lasts = 30min;
};

inline void PrintTo(const HealthyPlant& plant, std::ostream* stream) { *stream << plant.name; }

/// Registers that each of them has.
inline Registers registers_of(const sim::DeviceSettings& drive) {
  switch (drive.model) {
    case sim::ModelKind::moons: return {drive.address, 0x003C, 4};
    case sim::ModelKind::stepper: return {drive.address, 0x00D8, 2};
    case sim::ModelKind::aic: return {drive.address, 0x0002, 6};
    case sim::ModelKind::fda6000: return {drive.address, 0x00C8, 8};
  }
  return {drive.address, 0, 1};
}

/// The drives are of four makers in turn; ASCII is spoken by one of them only.
inline OneBus bus_of(const HealthyPlant& plant) {
  constexpr std::array kModels = {sim::ModelKind::moons, sim::ModelKind::stepper,
                                  sim::ModelKind::aic, sim::ModelKind::fda6000};
  const bool is_ascii = plant.framing == bus::Framing::ascii;
  BusPlan plan = bus_plan({}, modbus::Baud{plant.baud});
  plan.bus.line.framing = plant.framing;
  plan.bus.line.format = {is_ascii ? 7U : 8U, modbus::Parity::even, 1};
  plan.bus.line.echo = plant.echo ? std::optional(true) : std::nullopt;
  if (plant.framing == bus::Framing::tcp) {
    plan.bus.line.remote = bus::Endpoint{"192.0.2.1"};
  }
  for (unsigned at = 0; at < plant.drives; ++at) {
    sim::DeviceSettings& drive = plan.devices.emplace_back();
    drive.name = "drive-" + std::to_string(at);
    drive.address = static_cast<std::uint8_t>(at + 1);
    drive.model = is_ascii ? sim::ModelKind::fda6000 : kModels.at(at % kModels.size());
    if (plant.drives_take > Duration{0}) {
      drive.faults.answer_after = plant.drives_take;
    }
  }
  OneBus bus = one_bus(plan);
  bus.settings.devices.push_back({"spare", BusId{0}, 200, plan.bus.timing});  // nobody asks it
  return bus;
}

class HealthyPlants : public testing::TestWithParam<HealthyPlant> {
 protected:
  HealthyPlants() {
    polling_.on_answer([this](const Answer& answer) {
      ++answers_;
      exceptions_ += answer.is_exception() ? 1U : 0U;
    });
    for (unsigned number = 0; number < GetParam().clients; ++number) {
      polling_.add({.host = number,
                    .outstanding = 1,
                    .next =
                        [this, turn = number]() mutable {
                          const auto& drives = bus_.devices[0];
                          return registers_of(drives[turn++ % drives.size()]);
                        },
                    .thinks =
                        [this, hurries = GetParam().hurries && number == 0] {
                          return hurries ? kThinkingTime : thinks_ * percent_(random_) / 100;
                        }});
    }
  }

  /// Ends at the first diagnosis.
  void run() {
    const Duration lasts = GetParam().lasts;
    for (Duration passed{0}; passed < lasts && !HasFailure(); passed += 1s) {
      polling_.run_for(1s);
      if (GetParam().is_disturbed) {
        disturb(static_cast<unsigned>(passed / 1s % 40));
      }
      const gateway::StatusReport report =
          polling_.world().gateway().report_status(passed, polling_.world().now());
      for (const gateway::Diagnosis& it : gateway::diagnose(report)) {
        ADD_FAILURE() << "after " << passed / 1s << " s, " << report.buses[0].load
                      << " % busy: " << it.subject << ": " << it.finding << " | " << it.evidence
                      << " | " << it.look_at;
      }
      most_load_ = std::max(most_load_, report.buses[0].load);
      if (GetParam().load > 0 && passed / 1s % 10 == 9) {
        keep_busy(report.buses[0].load);
      }
    }
  }

  std::uint64_t answers_ = 0;
  std::uint64_t exceptions_ = 0;
  unsigned most_load_ = 0;

 private:
  void disturb(unsigned second) {
    switch (second) {
      case 9: spoil_one_answer(&sim::Faults::silent); break;
      case 19: spoil_one_answer(&sim::Faults::bad_crc); break;
      case 29: polling_.world().clear_counters(); break;
      case 39:
        bus_.settings.buses[0].timing.response_timeout += 1ms;
        polling_.world().reload(bus_.settings);
        break;
      default: break;
    }
  }

  // At 9600 baud no two requests end in so short a time.
  void spoil_one_answer(bool sim::Faults::*fault) {
    const auto set_all = [&](bool is_spoilt) {
      for (sim::Device& device : polling_.world().wire(0).devices()) {
        sim::Faults faults = device.settings().faults;
        faults.*fault = is_spoilt;
        device.set_faults(faults);
      }
    };
    set_all(true);
    polling_.run_for(10ms);
    set_all(false);
  }

  // In small steps, because the load that is shown is that of the last ten seconds.
  void keep_busy(unsigned load) {
    const unsigned wanted = GetParam().load;
    if (load > wanted) {
      thinks_ = thinks_ * 105 / 100;
    } else if (load + 10 < wanted) {
      thinks_ = thinks_ * 90 / 100;
    } else if (load + 4 < wanted) {
      thinks_ = thinks_ * 97 / 100;
    }
  }

  OneBus bus_ = bus_of(GetParam());
  Polling polling_{bus_.settings, bus_.devices};
  Duration thinks_ = GetParam().thinks;
  std::mt19937 random_{20261125};
  std::uniform_int_distribution<int> percent_{50, 150};
};

}  // namespace mbgate::test

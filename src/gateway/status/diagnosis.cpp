// SPDX-License-Identifier: Apache-2.0
#include "gateway/status/diagnosis.hpp"

#include "gateway/status/findings.hpp"
#include "gateway/status/quality_text.hpp"

namespace mbgate::gateway {
namespace {

Diagnosis of_silent_device(const StatusReport& report, const DeviceStatus& device,
                           const Together& all) {
  const BusStatus& bus = report.buses[device.bus];
  std::string evidence =
      counted(device.silence.transmissions(), "transmission") + " in a row unanswered";
  if (!device.has_answered) {
    if (all.asked > all.silent) {
      evidence += "; others on " + bus.name + " answer";
    }
    return {
        subject_of(report, device), "it has never answered", std::move(evidence),
        "its power; its address " + std::to_string(device.address) +
            (bus.is_serial ? "; its baud rate and parity, here " + mode_text(bus) + "; its wires"
                           : "")};
  }
  if (device.last_answer) {
    evidence += "; the last answer came " + seconds_text(*device.last_answer) + " ago";
  }
  return {subject_of(report, device), "it does not answer any more", std::move(evidence),
          "its power, its cable; whether it answers later than response_timeout, " +
              milliseconds_text(device.response_timeout)};
}

// On a line that hears what it sends, the answer to a write comes behind its echo, which looks the
// same.
Diagnosis of_second_answer(const StatusReport& report, const DeviceStatus& device) {
  return {subject_of(report, device), "two answers came to one request",
          "the last time " + seconds_text(*device.last_second_answer) + " ago",
          "two devices at address " + std::to_string(device.address) +
              "; another client on this line that asks it; whether the line hears what it sends "
              "(`echo`)"};
}

Diagnosis of_other_order(const StatusReport& report, const DeviceStatus& device) {
  const OtherWordOrder& other = *device.other_order;
  std::string expected;
  for (const std::uint16_t value : other.expected) {
    expected += (expected.empty() ? "" : " or ") + std::to_string(value);
  }
  return {subject_of(report, device), "its word order is not the configured one",
          "its holding register " + std::to_string(other.address) + " held " +
              std::to_string(other.holds) + " when it was last read; " + expected +
              " is what was configured",
          "`word_order`, or the setting of the drive; until then no values are written to it"};
}

void diagnose_device(const StatusReport& report, const DeviceStatus& device, const Together& all,
                     std::vector<Diagnosis>& found) {
  const BusStatus& bus = report.buses[device.bus];
  if (!is_asked(device)) {
    return;
  }
  if (is_lately(device.last_second_answer) && bus.echo == bus::NoticedEcho::none) {
    found.push_back(of_second_answer(report, device));
  }
  if (!speaks(device)) {
    if (bus.is_open && !all.is_dead() && bus.echo != bus::NoticedEcho::denied) {
      found.push_back(of_silent_device(report, device, all));
    }
  } else if (is_bad(device.quality)) {
    found.push_back(diagnosis_of_quality(subject_of(report, device), device.quality, false));
  }
  if (device.other_order) {
    found.push_back(of_other_order(report, device));
  }
}

}  // namespace

std::vector<Diagnosis> diagnose(const StatusReport& report) {
  std::vector<Diagnosis> found;
  std::vector<Together> all;
  for (std::size_t place = 0; place < report.buses.size(); ++place) {
    all.push_back(together(report, place));
    diagnose_bus(report, report.buses[place], all.back(), found);
  }
  for (const DeviceStatus& device : report.devices) {
    diagnose_device(report, device, all[device.bus], found);
  }
  return found;
}

}  // namespace mbgate::gateway

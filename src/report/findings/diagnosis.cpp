// SPDX-License-Identifier: Apache-2.0
#include "report/findings/diagnosis.hpp"

#include <algorithm>
#include <fmt/core.h>

#include "base/text.hpp"
#include "report/findings/findings.hpp"

namespace mbgate::report {
namespace {

using namespace gateway;

constexpr std::size_t kMostRanges = 8;  // of addresses that are named one by one

using Devices = std::vector<const DeviceStatus*>;

std::string others_answer(const StatusReport& report, const DeviceStatus& device) {
  return do_others_answer(report, device)
             ? fmt::format("; others on {} answer", report.buses[device.bus].name)
             : "";
}

// The settings that a drive must have in common with its line.
std::string mode_of_drives(const BusStatus& bus) {
  if (bus.is_serial) {
    return fmt::format("; its baud rate and parity, here {}; its wires", mode_text(bus));
  }
  return is_behind_a_server(bus)
             ? "; its baud rate and parity, and those of the serial server; its wires"
             : "";
}

Diagnosis of_silent_device(const StatusReport& report, const DeviceStatus& device) {
  const BusStatus& bus = report.buses[device.bus];
  const std::string address = std::to_string(device.address);
  std::string evidence =
      counted(device.silence.transmissions(), "transmission") + " in a row unanswered";
  if (device.unreached) {
    return {Rank::drive_lost, subject_of(report, device), "the server does not reach it",
            fmt::format("{}; the server says {}{}", evidence,
                        modbus::exception_text(*device.unreached), others_answer(report, device)),
            "its power, its cable; its unit identifier, and its settings in the server"};
  }
  if (!device.has_answered) {
    return {Rank::drive_lost, subject_of(report, device), "it has never answered",
            evidence + others_answer(report, device),
            fmt::format("its power; its address {}{}", address, mode_of_drives(bus))};
  }
  if (device.last_answer) {
    evidence += fmt::format("; the last answer came {} ago", passed_text(*device.last_answer));
  }
  const bool is_on_a_line = bus.framing != bus::Framing::tcp;
  return {
      Rank::drive_lost, subject_of(report, device), "it does not answer any more",
      std::move(evidence),
      fmt::format("its power, its cable; {}; whether it answers later than response_timeout, {}",
                  is_on_a_line ? fmt::format("its address, baud rate and parity, if it was "
                                             "replaced or reset; a second device at address {}",
                                             address)
                               : "its address, if it was replaced or reset",
                  milliseconds_text(device.response_timeout))};
}

Diagnosis of_device_nobody_asks(const StatusReport& report, const DeviceStatus& device) {
  return {Rank::warning, subject_of(report, device), "it did not answer when it was last asked",
          fmt::format("that was {} ago", passed_text(*device.last_request)),
          "whether it should be asked; its power, its cable"};
}

// "3, 7 to 12"
std::string ranges_of(const Devices& devices) {
  std::string text;
  std::size_t ranges = 0;
  for (std::size_t first = 0; first < devices.size(); ++ranges) {
    std::size_t end = first + 1;
    while (end < devices.size() && devices[end]->address == devices[end - 1]->address + 1) {
      ++end;
    }
    if (ranges == kMostRanges) {
      return fmt::format("{} and {} more", text, devices.size() - first);
    }
    text += (text.empty() ? "" : ", ") + std::to_string(devices[first]->address);
    if (end - first > 1) {
      text += fmt::format(" to {}", devices[end - 1]->address);
    }
    first = end;
  }
  return text;
}

// Addresses that nobody names and that have never answered: a client asks for what is not there, or
// tries all of them.
void diagnose_tried(const StatusReport& report, const Devices& tried, const Together& all,
                    std::vector<Diagnosis>& found) {
  if (tried.empty()) {
    return;
  }
  Diagnosis one = of_silent_device(report, *tried.front());
  one.rank = all.has_names ? Rank::warning : Rank::drive_lost;
  one.look_at = "the unit identifier that the client asks for; " + one.look_at;
  if (tried.size() > 1) {
    const auto* longest = *std::ranges::max_element(tried, {}, &DeviceStatus::silent_for);
    const BusStatus& bus = report.buses[tried.front()->bus];
    one.subject = subject_of(bus);
    one.finding = fmt::format("{} addresses have never answered", tried.size());
    one.evidence = ranges_of(tried) + others_answer(report, *longest);
    one.look_at =
        "the unit identifiers that a client asks for; if drives should be there: their "
        "power, addresses, wires and settings";
  }
  found.push_back(std::move(one));
}

// As long as the gateway does not know that the adapter receives what it sends, the answer to a
// write comes behind its echo, which looks the same.
Diagnosis of_second_answer(const StatusReport& report, const DeviceStatus& device) {
  return {Rank::bad_answers, subject_of(report, device), "two answers came to one request",
          fmt::format("the last time {} ago", passed_text(*device.last_second_answer)),
          fmt::format("two devices at address {}; another client on this line that asks it; "
                      "whether the adapter receives what it sends (`echo`)",
                      device.address)};
}

Diagnosis of_other_order(const StatusReport& report, const DeviceStatus& device) {
  const OtherWordOrder& other = *device.other_order;
  std::string expected;
  for (const std::uint16_t value : other.expected) {
    expected += (expected.empty() ? "" : " or ") + std::to_string(value);
  }
  return {
      Rank::bad_answers, subject_of(report, device), "its word order is not the configured one",
      fmt::format(
          "its holding register {} held {} when it was last read; the configured word order has {}",
          other.address, other.holds, expected),
      "`word_order`, or the setting of the drive; until then no values are written to it"};
}

Diagnosis of_failed_stop(const StatusReport& report, const DeviceStatus& device) {
  const std::uint8_t exception = device.stop_exception;
  return {Rank::drive_lost, subject_of(report, device),
          exception == 0 ? "it has not acknowledged a stop" : "it has refused a stop",
          fmt::format("{} to the last try, {} ago",
                      exception == 0 ? "no answer" : modbus::exception_text(exception),
                      passed_text(*device.last_failed_stop)),
          "whether it stands still"};
}

// Is it that of the device, and not of its line?
bool is_silence_its_own(const BusStatus& bus, const Together& all) {
  return (bus.is_open || bus.is_reopening) && !all.is_dead() && !hides_answers(bus.echo);
}

bool is_tried(const DeviceStatus& device) {
  return !is_drive(device) && !speaks(device) && is_asked(device);
}

void diagnose_device(const StatusReport& report, const DeviceStatus& device, const Together& all,
                     std::vector<Diagnosis>& found) {
  if (!device.last_request || (device.name.empty() && !is_asked(device)) || is_tried(device)) {
    return;
  }
  if (device.last_failed_stop) {
    found.push_back(of_failed_stop(report, device));
  }
  if (is_lately(device.last_second_answer)) {
    found.push_back(of_second_answer(report, device));
  }
  if (!speaks(device)) {
    if (is_silence_its_own(report.buses[device.bus], all)) {
      found.push_back(is_asked(device) ? of_silent_device(report, device)
                                       : of_device_nobody_asks(report, device));
    }
  } else if (is_bad(device.quality)) {
    found.push_back(quality_finding(device.quality, false));
    found.back().subject = subject_of(report, device);
  }
  if (device.other_order) {
    found.push_back(of_other_order(report, device));
  }
}

Devices tried_on(const StatusReport& report, std::size_t bus) {
  Devices tried;
  for (const DeviceStatus& device : report.devices) {
    if (device.bus == bus && is_tried(device)) {
      tried.push_back(&device);
    }
  }
  return tried;
}

// Not all is well where more than one request in a hundred fails, whatever the reason.
void diagnose_failures(const StatusReport& report, std::vector<Diagnosis>& found) {
  constexpr unsigned kPercent = 100;
  for (const ListenerStatus& listener : report.listeners) {
    const RecentFailures& recent = listener.counters.recent;
    // Clients may ask seldom, and what has succeeded since was perhaps mended.
    const Duration lately = std::chrono::minutes(recent.is_failing ? 10 : 1);
    const unsigned least = recent.is_failing ? 3 : 5;
    if (listener.last_failure.value_or(lately) >= lately || recent.failures < least ||
        recent.failures * kPercent <= recent.requests) {
      continue;
    }
    found.push_back(
        {Rank::bad_answers, "listener " + listener.name,
         fmt::format("{} % of its requests fail",
                     std::min(recent.failures * kPercent / recent.requests, kPercent)),
         fmt::format("{} of the last {}; the last one got {}", recent.failures, recent.requests,
                     recent.last == 0 ? "no answer before its client gave up"
                                      : modbus::exception_text(recent.last)),
         recent.last == 0 ? "the timeout of the client, and the times of the devices"
                          : "TIMEOUTS of the devices; the journal says what was refused, and why"});
  }
}

}  // namespace

std::vector<Diagnosis> diagnose(const StatusReport& report) {
  std::vector<Diagnosis> found;
  std::vector<Together> all;
  for (std::size_t place = 0; place < report.buses.size(); ++place) {
    all.push_back(together(report, place));
    diagnose_bus(report.buses[place], all.back(), found);
  }
  for (const DeviceStatus& device : report.devices) {
    diagnose_device(report, device, all[device.bus], found);
  }
  for (std::size_t place = 0; place < report.buses.size(); ++place) {
    if (is_silence_its_own(report.buses[place], all[place])) {
      diagnose_tried(report, tried_on(report, place), all[place], found);
    }
  }
  if (found.empty()) {
    diagnose_failures(report, found);
  }
  std::ranges::stable_sort(found, {}, &Diagnosis::rank);
  return found;
}

}  // namespace mbgate::report

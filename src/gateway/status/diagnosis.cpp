// SPDX-License-Identifier: Apache-2.0
#include "gateway/status/diagnosis.hpp"

#include <algorithm>

#include "gateway/status/quality_text.hpp"

namespace mbgate::gateway {
namespace {

// So many requests in a row are unanswered before it is said: one alone may be a disturbance.
constexpr unsigned kUnansweredInRow = 3;
// A line is asked for too much if it is hardly ever idle and half of the requests wait for so long.
constexpr unsigned kFullLoad = 95;
constexpr Duration kLongWait = std::chrono::milliseconds(500);

bool is_bad(const bus::QualityVerdict& verdict) {
  return verdict.quality != bus::Quality::unknown && verdict.quality != bus::Quality::good;
}

std::string counted(std::uint64_t count, const char* one) {
  return std::to_string(count) + " " + one + (count == 1 ? "" : "s");
}

std::string milliseconds_text(Duration duration) {
  return std::to_string(std::chrono::ceil<std::chrono::milliseconds>(duration).count()) + " ms";
}

std::string seconds_text(Duration duration) {
  return std::to_string(std::chrono::floor<std::chrono::seconds>(duration).count()) + " s";
}

std::string mode_text(const BusStatus& bus) {
  return std::to_string(static_cast<std::uint32_t>(bus.baud)) + " baud " + format_text(bus.format);
}

std::string subject(const BusStatus& bus) { return "bus " + bus.name; }

std::string subject(const StatusReport& report, const DeviceStatus& device) {
  return device.name.empty()
             ? subject(report.buses[device.bus]) + " address " + std::to_string(device.address)
             : "device " + device.name;
}

Diagnosis of_quality(std::string about, const bus::QualityVerdict& verdict, bool is_of_line) {
  QualityFinding found = quality_finding(verdict, is_of_line);
  return {std::move(about), std::move(found.finding), std::move(found.evidence),
          std::move(found.look_at)};
}

/// What the devices of a bus have in common.
struct Together {
  std::uint64_t asked = 0;  ///< devices
  std::uint64_t requests = 0;
  bool any_answers = false;  ///< in whatever way
  std::optional<Duration> typical_wait;
};

Together together(const StatusReport& report, std::size_t bus) {
  Together all;
  for (const DeviceStatus& device : report.devices) {
    if (device.bus != bus || device.counters.transmissions == 0) {
      continue;
    }
    ++all.asked;
    all.requests += device.counters.transmissions;
    all.any_answers = all.any_answers || device.has_answered || device.counters.bad_crcs > 0 ||
                      device.counters.late_responses > 0 || is_bad(device.quality);
    all.typical_wait = std::max(all.typical_wait, device.queue.p50);
  }
  return all;
}

bool is_dead(const Together& all) { return !all.any_answers && all.requests >= kUnansweredInRow; }

void diagnose_bus(const StatusReport& report, std::size_t place, std::vector<Diagnosis>& found) {
  const BusStatus& bus = report.buses[place];
  const Together all = together(report, place);
  if (!bus.is_open) {
    found.push_back({subject(bus), "it is not open: nothing can be sent",
                     bus.line + " could not be opened, or was lost",
                     bus.is_serial
                         ? "the adapter and its plug; `device`; who else has the port open"
                         : "the network, the server and its port"});
  } else if (is_dead(all)) {
    found.push_back(
        {subject(bus), "nothing answers",
         "no answer to " + counted(all.requests, "request") + " to " +
             counted(all.asked, "device") + ", nor anything else",
         bus.is_serial
             ? "power; A and B; unit addresses; the drives' setting, here " + mode_text(bus)
             : "unit identifiers; whether the server is a Modbus TCP server"});
  }
  if (is_bad(bus.quality)) {
    found.push_back(of_quality(subject(bus), bus.quality, true));
  }
  if (bus.counters.foreign_frames > 0) {
    found.push_back(
        {subject(bus), "another client is on this line",
         counted(bus.counters.foreign_frames, "frame") +
             " heard that nobody here sent or asked for",
         "a second gateway, PLC or tool on the same wires: an RS-485 line has one client"});
  }
  if (bus.load >= kFullLoad && all.typical_wait && *all.typical_wait >= kLongWait) {
    found.push_back({subject(bus), "it is asked for more than it can carry",
                     "busy " + std::to_string(bus.load) +
                         " % of the time; half of the requests wait " +
                         milliseconds_text(*all.typical_wait) + " or longer",
                     "poll less often; longer reads instead of many; `cache`, `merge`; baud rate"});
  }
}

void diagnose_device(const StatusReport& report, const DeviceStatus& device,
                     std::vector<Diagnosis>& found) {
  const BusStatus& bus = report.buses[device.bus];
  if (is_bad(device.quality)) {
    found.push_back(of_quality(subject(report, device), device.quality, false));
    return;
  }
  const bool is_explained = !bus.is_open || is_dead(together(report, device.bus));
  if (is_explained || device.unanswered_in_row < kUnansweredInRow) {
    return;
  }
  const std::string evidence =
      counted(device.unanswered_in_row, "request") + " in a row unanswered";
  if (!device.has_answered) {
    found.push_back({subject(report, device), "it has never answered",
                     evidence + "; others on " + bus.name + " answer",
                     "its power; its address " + std::to_string(device.address) +
                         "; its baud rate and parity, here " + mode_text(bus) + "; its wires"});
    return;
  }
  found.push_back({subject(report, device), "it does not answer any more",
                   evidence + (device.last_answer ? "; the last answer came " +
                                                        seconds_text(*device.last_answer) + " ago"
                                                  : ""),
                   "its power, its cable; whether it answers later than response_timeout, " +
                       milliseconds_text(device.response_timeout)});
}

}  // namespace

std::vector<Diagnosis> diagnose(const StatusReport& report) {
  std::vector<Diagnosis> found;
  for (std::size_t place = 0; place < report.buses.size(); ++place) {
    diagnose_bus(report, place, found);
  }
  for (const DeviceStatus& device : report.devices) {
    diagnose_device(report, device, found);
  }
  return found;
}

}  // namespace mbgate::gateway

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
// What was noticed once is no matter of today.
constexpr Duration kLately = std::chrono::minutes(10);

std::string counted(std::uint64_t count, const char* one) {
  return std::to_string(count) + " " + one + (count == 1 ? "" : "s");
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

/// Bytes come from it, whatever they are. Bad CRCs of earlier say nothing of a device that is
/// silent now.
bool speaks(const DeviceStatus& device) {
  const bus::Quality quality = device.quality.quality;
  return device.unanswered_in_row < kUnansweredInRow || quality == bus::Quality::no_frame ||
         quality == bus::Quality::late;
}

/// Addresses without a device count only as long as somebody asks them.
bool is_asked(const DeviceStatus& device) {
  return device.last_request && (!device.name.empty() || *device.last_request < kLately);
}

/// What the devices of a bus have in common.
struct Together {
  std::uint64_t asked = 0;  ///< devices
  std::uint64_t silent = 0;
  std::uint64_t unanswered = 0;  ///< requests in a row, of all of them
  bool had_answers = false;
  std::optional<Duration> shortest_wait;  ///< the median of each answering device, the least of it

  /// One alone that has answered before: that is told of the device.
  [[nodiscard]] bool is_dead() const { return silent > 0 && silent == asked && !is_one_of_old(); }
  [[nodiscard]] bool is_one_of_old() const { return asked == 1 && had_answers; }
};

Together together(const StatusReport& report, std::size_t bus) {
  Together all;
  for (const DeviceStatus& device : report.devices) {
    if (device.bus != bus || !is_asked(device)) {
      continue;
    }
    ++all.asked;
    all.had_answers = all.had_answers || device.has_answered;
    if (!speaks(device)) {
      ++all.silent;
      all.unanswered += device.unanswered_in_row;
    } else if (device.queue.p50 && !is_bad(device.quality)) {
      all.shortest_wait = std::min(all.shortest_wait.value_or(Duration::max()), *device.queue.p50);
    }
  }
  return all;
}

Diagnosis of_dead_bus(const BusStatus& bus, const Together& all) {
  const std::string evidence = counted(all.unanswered, "request") + " in a row to " +
                               counted(all.silent, "device") +
                               " unanswered, and nothing else heard";
  if (all.had_answers) {
    return {subject(bus), "nothing answers any more", evidence,
            bus.is_serial ? "the plug and the cable of the line; the power of the drives"
                          : "the server and what is behind it"};
  }
  return {subject(bus), "nothing answers", evidence,
          bus.is_serial
              ? "power; A and B; unit addresses; the drives' setting, here " + mode_text(bus)
              : "unit identifiers; whether the server is a Modbus TCP server"};
}

void diagnose_bus(const BusStatus& bus, const Together& all, std::vector<Diagnosis>& found) {
  if (!bus.is_open && !bus.is_starting) {
    found.push_back({subject(bus), "it is not open: nothing can be sent",
                     bus.line + " could not be opened, or was lost",
                     bus.is_serial
                         ? "the adapter and its plug; `device`; who else has the port open"
                         : "the network, the server and its port"});
  } else if (all.is_dead()) {
    found.push_back(of_dead_bus(bus, all));
  }
  if (is_bad(bus.quality)) {
    found.push_back(of_quality(subject(bus), bus.quality, true));
  }
  if (bus.last_foreign && *bus.last_foreign < kLately) {
    found.push_back({subject(bus), "frames are heard that nobody here sent or asked for",
                     "the last one " + seconds_text(*bus.last_foreign) + " ago, " +
                         std::to_string(bus.counters.foreign_frames) + " in all",
                     "another client on this line (a second gateway, PLC or tool), or two devices "
                     "at one address"});
  }
  if (bus.load >= kFullLoad && all.shortest_wait && *all.shortest_wait >= kLongWait) {
    found.push_back({subject(bus), "it is asked for more than it can carry",
                     "busy " + std::to_string(bus.load) +
                         " % of the time; half of the requests wait " +
                         milliseconds_text(*all.shortest_wait) + " or longer",
                     "poll less often; longer reads instead of many; `cache`, `merge`; baud rate"});
  }
}

Diagnosis of_silent_device(const StatusReport& report, const DeviceStatus& device,
                           const Together& all) {
  const BusStatus& bus = report.buses[device.bus];
  std::string evidence = counted(device.unanswered_in_row, "request") + " in a row unanswered";
  if (!device.has_answered) {
    if (all.asked > all.silent) {
      evidence += "; others on " + bus.name + " answer";
    }
    return {
        subject(report, device), "it has never answered", std::move(evidence),
        "its power; its address " + std::to_string(device.address) +
            (bus.is_serial ? "; its baud rate and parity, here " + mode_text(bus) + "; its wires"
                           : "")};
  }
  if (device.last_answer) {
    evidence += "; the last answer came " + seconds_text(*device.last_answer) + " ago";
  }
  return {subject(report, device), "it does not answer any more", std::move(evidence),
          "its power, its cable; whether it answers later than response_timeout, " +
              milliseconds_text(device.response_timeout)};
}

void diagnose_device(const StatusReport& report, const DeviceStatus& device, const Together& all,
                     std::vector<Diagnosis>& found) {
  const BusStatus& bus = report.buses[device.bus];
  if (!is_asked(device)) {
    return;
  }
  if (speaks(device)) {
    if (is_bad(device.quality)) {
      found.push_back(of_quality(subject(report, device), device.quality, false));
    }
  } else if (bus.is_open && !all.is_dead()) {
    found.push_back(of_silent_device(report, device, all));
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
  return found;
}

}  // namespace mbgate::gateway

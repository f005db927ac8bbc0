// SPDX-License-Identifier: Apache-2.0
#include "gateway/status/findings.hpp"

#include <algorithm>

#include "gateway/status/quality_text.hpp"

namespace mbgate::gateway {
namespace {

// So many transmissions in a row, of so many requests, are unanswered before it is said: one
// request alone with its repetitions may be a disturbance.
constexpr unsigned kUnansweredInRow = 3;
constexpr unsigned kRequestsInRow = 2;
constexpr Duration kLately = std::chrono::minutes(10);

// Requests to an offline device are answered at once; its probes take hardly any time.
bool is_waited_for(const DeviceStatus& device) {
  const bus::Quality quality = device.quality.quality;
  return quality == bus::Quality::late || quality == bus::Quality::no_frame ||
         (device.unanswered_in_row >= kUnansweredInRow &&
          device.state != DeviceStatus::State::offline);
}

}  // namespace

std::string counted(std::uint64_t count, const char* one) {
  return std::to_string(count) + " " + one + (count == 1 ? "" : "s");
}

std::string seconds_text(Duration duration) {
  return std::to_string(std::chrono::floor<std::chrono::seconds>(duration).count()) + " s";
}

std::string mode_text(const BusStatus& bus) {
  return std::to_string(static_cast<std::uint32_t>(bus.baud)) + " baud " + format_text(bus.format);
}

std::string subject_of(const BusStatus& bus) { return "bus " + bus.name; }

std::string subject_of(const StatusReport& report, const DeviceStatus& device) {
  return device.name.empty()
             ? subject_of(report.buses[device.bus]) + " address " + std::to_string(device.address)
             : "device " + device.name;
}

bool is_lately(const std::optional<Duration>& ago) { return ago && *ago < kLately; }

bool speaks(const DeviceStatus& device) {
  const bus::Quality quality = device.quality.quality;
  return device.silence.transmissions() < kUnansweredInRow ||
         device.silence.requests() < kRequestsInRow || quality == bus::Quality::no_frame ||
         quality == bus::Quality::late;
}

bool is_asked(const DeviceStatus& device) {
  return !device.name.empty() ? device.last_request.has_value() : is_lately(device.last_request);
}

Diagnosis diagnosis_of_quality(std::string subject, const bus::QualityVerdict& verdict,
                               bool is_of_line) {
  QualityFinding found = quality_finding(verdict, is_of_line);
  return {std::move(subject), std::move(found.finding), std::move(found.evidence),
          std::move(found.look_at)};
}

Together together(const StatusReport& report, std::size_t bus) {
  Together all;
  for (const DeviceStatus& device : report.devices) {
    if (device.bus != bus || !is_asked(device)) {
      continue;
    }
    ++all.asked;
    all.had_answers = all.had_answers || device.has_answered;
    all.are_waited_for = all.are_waited_for || is_waited_for(device);
    if (!speaks(device)) {
      ++all.silent;
      all.unanswered += device.silence.transmissions();
    } else if (device.queue.p50 && !is_bad(device.quality)) {
      all.shortest_wait = std::min(all.shortest_wait.value_or(Duration::max()), *device.queue.p50);
    }
  }
  return all;
}

}  // namespace mbgate::gateway

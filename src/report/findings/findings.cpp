// SPDX-License-Identifier: Apache-2.0
#include "report/findings/findings.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace mbgate::report {
namespace {

using namespace gateway;

// So many transmissions in a row, of so many requests, are unanswered before it is said: one
// request alone with its repetitions may be a disturbance.
constexpr unsigned kUnansweredInRow = 3;
constexpr unsigned kRequestsInRow = 2;
constexpr Duration kLately = std::chrono::minutes(10);
// A client that tries all addresses is forgotten sooner.
constexpr Duration kTriedLately = std::chrono::minutes(3);

// It answers, if not so that it is understood in time.
bool is_misheard(const DeviceStatus& device) {
  const bus::Quality quality = device.quality.quality;
  return quality == bus::Quality::late || quality == bus::Quality::no_frame;
}

// Requests to an offline device are answered at once; its probes take hardly any time.
bool is_waited_for(const DeviceStatus& device) {
  return is_asked(device) &&
         (is_misheard(device) || (device.unanswered_in_row >= kUnansweredInRow &&
                                  device.state != DeviceStatus::State::offline));
}

// A drive that was asked before the others fell silent says nothing of the line now. A request that
// has just been sent is taken for answered.
bool was_heard_within(const DeviceStatus& device, Duration ago) {
  const bool any_answer = device.silence.transmissions() == 0 || is_misheard(device);
  const std::optional<Duration>& last = any_answer ? device.last_request : device.last_answer;
  return last && *last <= ago;
}

}  // namespace

std::string mode_text(const BusStatus& bus) {
  return fmt::format("{} baud {}", fmt::underlying(bus.baud), format_text(bus.format));
}

bool is_behind_a_server(const BusStatus& bus) {
  return !bus.is_serial && bus.framing != bus::Framing::tcp;
}

std::string milliseconds_text(bus::Duration duration) {
  return fmt::format("{} ms", std::chrono::ceil<std::chrono::milliseconds>(duration).count());
}

bool is_bad(const bus::QualityVerdict& verdict) {
  return verdict.quality != bus::Quality::unknown && verdict.quality != bus::Quality::good;
}

std::string subject_of(const BusStatus& bus) { return "bus " + bus.name; }

std::string subject_of(const StatusReport& report, const DeviceStatus& device) {
  return device.name.empty()
             ? fmt::format("{} address {}", subject_of(report.buses[device.bus]), device.address)
             : "device " + device.name;
}

bool is_lately(const std::optional<Duration>& ago) { return ago && *ago < kLately; }

bool speaks(const DeviceStatus& device) {
  const bool is_silent = device.state == DeviceStatus::State::offline ||
                         (device.silence.transmissions() >= kUnansweredInRow &&
                          device.silence.requests() >= kRequestsInRow);
  return !is_silent || is_misheard(device);
}

bool is_asked(const DeviceStatus& device) {
  return device.last_request &&
         *device.last_request < (device.name.empty() ? kTriedLately : kLately);
}

bool is_drive(const DeviceStatus& device) { return !device.name.empty() || device.has_answered; }

bool do_others_answer(const StatusReport& report, const DeviceStatus& device) {
  return std::ranges::any_of(report.devices, [&](const DeviceStatus& other) {
    return &other != &device && other.bus == device.bus && other.last_answer &&
           *other.last_answer <= device.silent_for;
  });
}

Diagnosis quality_finding(const bus::QualityVerdict& verdict, bool is_of_line) {
  switch (verdict.quality) {
    case bus::Quality::unknown:
    case bus::Quality::good: break;
    case bus::Quality::bad_crc:
      return {
          Rank::bad_answers,
          {},
          fmt::format("bad CRC in {} % of its answers", verdict.percent()),
          fmt::format("{} of {}", verdict.count, verdict.of),
          fmt::format("termination, bias, cable{}",
                      is_of_line
                          ? "; several devices have it; another client that sends at the same time"
                          : ", or two devices at one address")};
    case bus::Quality::no_frame:
      return {Rank::drive_lost,
              {},
              "something answers, but no valid frame",
              fmt::format("bytes came after each of {} requests", verdict.of),
              "baud rate, parity, A and B exchanged, two devices at one address?"};
    case bus::Quality::late:
      return {Rank::bad_answers,
              {},
              fmt::format("its answers come {} after its response timeout",
                          milliseconds_text(verdict.lateness)),
              fmt::format("after {} of its last {} requests", verdict.count, verdict.of),
              "set response_timeout to at least " + milliseconds_text(verdict.needed)};
  }
  return {};
}

std::string quality_text(const bus::QualityNotice& notice) {
  const bus::QualityVerdict& verdict = notice.verdict;
  if (!is_bad(verdict)) {
    return "its answers are good now";
  }
  const Diagnosis found = quality_finding(verdict, !notice.address);
  return fmt::format("{} ({}){}{}", found.finding, found.evidence,
                     verdict.quality == bus::Quality::late ? "; " : ": ", found.look_at);
}

Together together(const StatusReport& report, std::size_t bus) {
  Together all;
  std::vector<const DeviceStatus*> asked;
  bool has_drive = false;  // one that is asked, or that answered when it was asked last
  for (const DeviceStatus& device : report.devices) {
    if (device.bus != bus) {
      continue;
    }
    all.had_answers = all.had_answers || device.has_answered;
    all.has_names = all.has_names || !device.name.empty();
    all.are_waited_for = all.are_waited_for || is_waited_for(device);
    has_drive = has_drive ||
                (is_drive(device) && (is_asked(device) || (device.has_answered && speaks(device))));
    if (is_asked(device)) {
      asked.push_back(&device);
    }
  }
  Duration last_fell = Duration::max();
  for (const DeviceStatus* device : asked) {
    if (!speaks(*device) && (is_drive(*device) || !has_drive)) {
      ++all.silent;
      all.unreached += static_cast<unsigned>(device->unreached.has_value());
      all.unanswered += device->silence.transmissions();
      all.silent_for = std::max(all.silent_for, device->silent_for);
      last_fell = std::min(last_fell, device->silent_for);
    }
  }
  all.does_one_speak = std::ranges::any_of(report.devices, [&](const DeviceStatus& device) {
    return device.bus == bus && speaks(device) && was_heard_within(device, last_fell);
  });
  return all;
}

}  // namespace mbgate::report

// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <fmt/core.h>
#include <optional>
#include <utility>

#include "app/metrics/metric_book.hpp"
#include "app/text.hpp"
#include "config/toml/match_entry.hpp"

namespace mbgate::app {
namespace {

using gateway::DeviceStatus;

struct DeviceCounter {
  MetricBook::Kind kind;
  std::uint64_t bus::DeviceCounters::*member;
};

constexpr std::array kDeviceCounters = {
    DeviceCounter{{"mbgate_device_transmissions_total", "Requests sent, repetitions included."},
                  &bus::DeviceCounters::transmissions},
    DeviceCounter{{"mbgate_device_responses_total", "Valid responses, exceptions included."},
                  &bus::DeviceCounters::responses},
    DeviceCounter{{"mbgate_device_timeouts_total", "Transmissions without a valid response."},
                  &bus::DeviceCounters::timeouts},
    DeviceCounter{{"mbgate_device_crc_errors_total", "Responses with a wrong CRC or LRC."},
                  &bus::DeviceCounters::bad_crcs},
    DeviceCounter{{"mbgate_device_late_responses_total", "Responses after their timeout."},
                  &bus::DeviceCounters::late_responses},
    DeviceCounter{
        {"mbgate_device_early_responses_total", "Responses before response_wait was over."},
        &bus::DeviceCounters::early_responses},
    DeviceCounter{{"mbgate_device_noise_bytes_total", "Bytes skipped before its responses."},
                  &bus::DeviceCounters::noise_bytes},
};

constexpr std::array kStates = {
    std::pair{DeviceStatus::State::not_asked, "not_asked"},
    std::pair{DeviceStatus::State::answering, "answering"},
    std::pair{DeviceStatus::State::not_answering, "not_answering"},
    std::pair{DeviceStatus::State::offline, "offline"},
    std::pair{DeviceStatus::State::damaged, "damaged_answers"},
    std::pair{DeviceStatus::State::line_not_open, "line_not_open"},
};

constexpr std::array kCodes = {"other", "01", "02", "03", "04", "05",
                               "06",    "07", "08", "09", "0A", "0B"};

Labels with(Labels labels, const char* name, std::string value) {
  labels.push_back({name, std::move(value)});
  return labels;
}

void add_counters(MetricBook& book, const Labels& labels, const DeviceStatus& device,
                  bool is_serial) {
  for (const DeviceCounter& counter : kDeviceCounters) {
    book.counter(counter.kind, labels, device.counters.*counter.member);
  }
  for (std::size_t code = 0; code < kCodes.size(); ++code) {
    const bus::ExceptionCounts& counts = device.counters.exceptions_by_code;
    book.counter({"mbgate_device_exceptions_total", "Exceptions of the device, by code."},
                 with(labels, "code", kCodes.at(code)),
                 code == 0 ? counts.others() : counts.of(static_cast<std::uint8_t>(code)));
  }
  book.counter({"mbgate_device_wire_seconds_total",
                "Time for which its requests had the line: its rate is its share of the bus."},
               labels, seconds_of(device.counters.wire_time));
  const MetricBook::Kind latency{"mbgate_device_latency_seconds",
                                 "Answered transactions: the wait for the line (queue), the frames "
                                 "(wire), the device itself (device)."};
  book.histogram(latency, with(labels, "part", "queue"), device.times.queue.all());
  if (is_serial) {  // on a connection nobody knows
    book.histogram(latency, with(labels, "part", "wire"), device.times.wire.all());
  }
  book.histogram(latency, with(labels, "part", "device"), device.times.device.all());
}

void add_state(MetricBook& book, const Labels& labels, const DeviceStatus& device) {
  for (const auto& [state, word] : kStates) {
    book.gauge({"mbgate_device_state", "1 for the state that the device is in."},
               with(labels, "state", word), device.state == state ? 1 : 0);
  }
  book.gauge({"mbgate_device_quarantine_seconds",
              "How long the device is held back after an unanswered request."},
             labels, seconds_of(device.quarantine));
  book.gauge({"mbgate_device_least_quarantine_seconds",
              "The configured quarantine; only late responses make it longer."},
             labels, seconds_of(device.least_quarantine));
  book.gauge({"mbgate_device_held_back_seconds", "How much longer the device gets only stops."},
             labels, seconds_of(device.held_back));
}

void add_to(DeviceStatus& sum, const DeviceStatus& device) {
  for (const DeviceCounter& counter : kDeviceCounters) {
    sum.counters.*counter.member += device.counters.*counter.member;
  }
  sum.counters.exceptions_by_code.add(device.counters.exceptions_by_code);
  sum.counters.wire_time += device.counters.wire_time;
  sum.times.queue.add_all(device.times.queue);
  sum.times.wire.add_all(device.times.wire);
  sum.times.device.add_all(device.times.device);
}

}  // namespace

void add_devices(MetricBook& book, const gateway::StatusReport& report) {
  std::vector<std::optional<DeviceStatus>> others(report.buses.size());
  for (const DeviceStatus& device : report.devices) {
    if (device.name.empty()) {
      add_to(others[device.bus] ? *others[device.bus] : others[device.bus].emplace(), device);
      continue;
    }
    const Labels labels{{"bus", report.buses[device.bus].name},
                        {"device", device.name},
                        {"address", std::to_string(device.address)}};
    add_state(book, labels, device);
    add_counters(book, labels, device, report.buses[device.bus].is_serial);
  }
  for (std::size_t bus = 0; bus < others.size(); ++bus) {
    if (others[bus]) {
      add_counters(book, {{"bus", report.buses[bus].name}, {"device", "other"}, {"address", ""}},
                   *others[bus], report.buses[bus].is_serial);
    }
  }
}

void add_bus(MetricBook& book, const gateway::BusStatus& bus) {
  const Labels of_bus{{"bus", bus.name}};
  Labels info{{"bus", bus.name},
              {"line", valid_utf8(bus.line)},
              {"framing", std::string(config::word_for(config::kFramings, bus.framing))}};
  if (bus.is_serial) {
    info.push_back({"baud", std::to_string(static_cast<std::uint32_t>(bus.baud))});
    info.push_back({"format", modbus::format_text(bus.format)});
  }
  book.gauge({"mbgate_bus_info", "The line of the bus."}, info, 1);
  book.gauge({"mbgate_bus_open", "Whether the line is open."}, of_bus, bus.is_open ? 1 : 0);
  book.counter({"mbgate_bus_busy_seconds_total",
                "Time in which the gateway sent or waited for an answer, with the silence after "
                "it: its rate is the load of the line."},
               of_bus, seconds_of(bus.busy));
  book.gauge({"mbgate_bus_waiting_requests", "Requests that wait for the bus."}, of_bus,
             bus.waiting);
  book.gauge({"mbgate_bus_longest_waiting_seconds",
              "The longest time that a request has been waiting; stops are not counted."},
             of_bus, seconds_of(bus.longest_waiting));
  for (const bus::CounterKind& counter : bus::kBusCounters) {
    const bool is_one_of_several = counter.reason != nullptr;
    const std::string metric = fmt::format("mbgate_bus_{}_total", counter.metric);
    book.counter({metric.c_str(), counter.help},
                 is_one_of_several ? with(of_bus, "reason", counter.reason) : of_bus,
                 bus.counters.*counter.member);
  }
  if (bus.is_serial) {
    book.histogram({"mbgate_bus_silence_seconds", "Silence on the line before each transmission."},
                   of_bus, bus.silences);
  }
}

}  // namespace mbgate::app

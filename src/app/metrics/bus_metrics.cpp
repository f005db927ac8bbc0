// SPDX-License-Identifier: Apache-2.0
#include "app/metrics/bus_metrics.hpp"

#include <array>

#include "app/framing_word.hpp"
#include "app/utf8.hpp"

namespace mbgate::app {
namespace {

struct BusRefusal {
  const char* reason;
  std::uint64_t bus::BusCounters::*member;
};

constexpr std::array kRefusals = {
    BusRefusal{"queue_full", &bus::BusCounters::refused_full},
    BusRefusal{"device_offline", &bus::BusCounters::refused_offline},
    BusRefusal{"deadline", &bus::BusCounters::expired},
    BusRefusal{"evicted", &bus::BusCounters::evicted},
};

}  // namespace

void add_bus(MetricBook& book, const gateway::BusStatus& bus) {
  const Labels of_bus{{"bus", bus.name}};
  Labels info{
      {"bus", bus.name}, {"line", valid_utf8(bus.line)}, {"framing", framing_word(bus.framing)}};
  if (bus.is_serial) {
    info.push_back({"baud", std::to_string(static_cast<std::uint32_t>(bus.baud))});
    info.push_back({"format", gateway::format_text(bus.format)});
  }
  book.gauge({"mbgate_bus_info", "The line of the bus."}, info, 1);
  book.gauge({"mbgate_bus_open", "Whether the line is open."}, of_bus, bus.is_open ? 1 : 0);
  book.counter({"mbgate_bus_busy_seconds_total",
                "Time in which something was sent or an answer waited for, with the silence after "
                "it: its rate is the load of the line."},
               of_bus, seconds_of(bus.busy));
  book.gauge({"mbgate_bus_waiting_requests", "Requests that wait for the bus."}, of_bus,
             static_cast<double>(bus.waiting));
  book.gauge({"mbgate_bus_longest_waiting_seconds",
              "How long the request has waited that waits longest; stops apart."},
             of_bus, seconds_of(bus.longest_waiting));
  for (const bus::CounterKind& counter : bus::kBusCounters) {
    if (counter.metric != nullptr) {
      book.counter({counter.metric, counter.help}, of_bus,
                   static_cast<double>(bus.counters.*counter.member));
    }
  }
  for (const BusRefusal& refusal : kRefusals) {
    book.counter({"mbgate_bus_refused_requests_total",
                  "Requests that were never sent, or not again, by reason."},
                 {{"bus", bus.name}, {"reason", refusal.reason}},
                 static_cast<double>(bus.counters.*refusal.member));
  }
  if (bus.is_serial) {
    book.histogram({"mbgate_bus_silence_seconds", "Silence on the line before each transmission."},
                   of_bus, bus.silences);
  }
}

}  // namespace mbgate::app

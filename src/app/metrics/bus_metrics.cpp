// SPDX-License-Identifier: Apache-2.0
#include "app/metrics/bus_metrics.hpp"

#include <array>

#include "app/framing_word.hpp"
#include "app/utf8.hpp"

namespace mbgate::app {
namespace {

struct BusCounter {
  MetricBook::Kind kind;
  std::uint64_t bus::BusCounters::*member;
};

constexpr std::array kBusCounters = {
    BusCounter{
        {"mbgate_bus_transmissions_total", "Frames sent, broadcasts and repetitions included."},
        &bus::BusCounters::transmissions},
    BusCounter{{"mbgate_bus_broadcasts_total", "Broadcasts sent."}, &bus::BusCounters::broadcasts},
    BusCounter{{"mbgate_bus_retries_total", "Requests sent again."}, &bus::BusCounters::retries},
    BusCounter{{"mbgate_bus_responses_total", "Valid responses, exceptions included."},
               &bus::BusCounters::responses},
    BusCounter{{"mbgate_bus_exceptions_total", "Responses that are exceptions of the device."},
               &bus::BusCounters::exceptions},
    BusCounter{{"mbgate_bus_timeouts_total", "Transmissions without a valid response."},
               &bus::BusCounters::timeouts},
    BusCounter{{"mbgate_bus_crc_errors_total", "Responses with a wrong CRC or LRC."},
               &bus::BusCounters::bad_crcs},
    BusCounter{{"mbgate_bus_late_responses_total", "Responses after their timeout."},
               &bus::BusCounters::late_responses},
    BusCounter{{"mbgate_bus_early_responses_total", "Responses before response_wait was over."},
               &bus::BusCounters::early_responses},
    BusCounter{
        {"mbgate_bus_unsolicited_frames_total", "Valid frames that answer no pending request."},
        &bus::BusCounters::unsolicited_frames},
    BusCounter{{"mbgate_bus_foreign_frames_total",
                "Requests of other clients on the line, and frames of devices that owed none."},
               &bus::BusCounters::foreign_frames},
    BusCounter{{"mbgate_bus_stray_bytes_total", "Bytes that belong to no frame."},
               &bus::BusCounters::stray_bytes},
    BusCounter{{"mbgate_bus_noise_bytes_total", "Bytes skipped before frames."},
               &bus::BusCounters::noise_bytes},
    BusCounter{{"mbgate_bus_echo_mismatches_total",
                "Transmissions that were heard differently than they were sent."},
               &bus::BusCounters::echo_mismatches},
    BusCounter{{"mbgate_bus_losses_total", "How often the line was lost."},
               &bus::BusCounters::losses},
    BusCounter{
        {"mbgate_bus_shared_reads_total", "Reads answered by the transmission of another request."},
        &bus::BusCounters::shared_reads},
    BusCounter{{"mbgate_bus_cached_reads_total", "Reads answered from the cache."},
               &bus::BusCounters::cached_reads},
    BusCounter{{"mbgate_bus_stops_total", "Stops sent, repetitions included."},
               &bus::BusCounters::stops},
    BusCounter{{"mbgate_bus_stops_unanswered_total", "Stops given up without being acknowledged."},
               &bus::BusCounters::stops_unanswered},
    BusCounter{{"mbgate_bus_overtaken_writes_total", "Waiting writes cancelled by a stop."},
               &bus::BusCounters::overtaken_writes},
    BusCounter{{"mbgate_bus_probes_total", "Requests sent to offline devices as probes."},
               &bus::BusCounters::probes},
};

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
  for (const BusCounter& counter : kBusCounters) {
    book.counter(counter.kind, of_bus, static_cast<double>(bus.counters.*counter.member));
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

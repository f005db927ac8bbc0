// SPDX-License-Identifier: Apache-2.0
#include "app/metrics/metrics.hpp"

#include <prometheus/text_serializer.h>

#include <utility>

#include "app/metrics/metric_book.hpp"
#include "report/findings/diagnosis.hpp"

namespace mbgate::app {
namespace {

void add_process(MetricBook& book, const gateway::StatusReport& report,
                 const ProcessStatus& process) {
  book.gauge({"mbgate_build_info", "The running version."}, {{"version", process.version}}, 1);
  book.gauge({"mbgate_config_last_reload_successful",
              "Whether the configuration was accepted when it was last read."},
             {}, process.reload_refused ? 0 : 1);
  book.gauge({"mbgate_config_info", "The SHA-256 of the files of the configuration in force."},
             {{"sha256", process.config_digest}}, 1);
  const auto read_at = process.config_read_at.time_since_epoch();
  book.gauge({"mbgate_config_last_reload_success_timestamp_seconds",
              "When the configuration in force was read."},
             {}, std::chrono::duration<double>(read_at).count());
  const auto seconds = [](std::chrono::system_clock::time_point time) {
    return std::chrono::duration<double>(time.time_since_epoch()).count();
  };
  for (const CertificateStatus& certificate : process.certificates) {
    book.gauge({"mbgate_certificate_expiry_timestamp_seconds",
                "When the certificate of a [[tls]] in use expires."},
               {{"tls", certificate.name}}, seconds(certificate.ends));
  }
  for (const CertificateStatus& certificate : process.certificates) {
    if (certificate.crl_ends) {
      book.gauge(
          {"mbgate_crl_expiry_timestamp_seconds", "When its list of revoked certificates expires."},
          {{"tls", certificate.name}}, seconds(*certificate.crl_ends));
    }
  }
  book.gauge({"mbgate_diagnoses", "Faults found at present: see mbgatectl status."}, {},
             report::diagnose(report).size());
  book.counter({"mbgate_foreign_adus_total", "Skipped ADUs of other protocols than Modbus."}, {},
               report.counters.foreign_adus);
  book.counter({"mbgate_framing_lost_total",
                "Connections closed because their client sent something other than Modbus TCP."},
               {}, report.counters.framing_lost);
}

void add_listener(MetricBook& book, const gateway::ListenerStatus& listener,
                  const std::map<std::string, std::uint64_t>& tls_failures) {
  const auto& counters = listener.counters;
  const auto labels = [&](Labels more = {}) {
    more.insert(more.begin(), {"listener", listener.name});
    return more;
  };
  book.gauge({"mbgate_listener_open_connections", "Connections of clients."}, labels(),
             listener.connections);
  book.counter({"mbgate_listener_connections_total", "Accepted connections."}, labels(),
               counters.connections);
  for (const auto& [limit, displaced] :
       {std::pair("max_connections", counters.displaced_full),
        std::pair("max_connections_per_address", counters.displaced_address_full)}) {
    book.counter({"mbgate_listener_displaced_connections_total",
                  "Connections closed to make room for others, by the limit that was reached."},
                 labels({{"limit", limit}}), displaced);
  }
  for (std::size_t place = 0; place < gateway::kRefusalNames.size(); ++place) {
    book.counter({"mbgate_listener_refused_connections_total", "Refused connections, by reason."},
                 labels({{"reason", gateway::kRefusalNames.at(place)}}),
                 counters.refused_connections.at(place));
  }
  const auto failures = tls_failures.find(listener.name);
  book.counter({"mbgate_listener_tls_failures_total",
                "Clients whose handshake failed or was refused, and those that a reload ended "
                "because of their certificate."},
               labels(), failures == tls_failures.end() ? 0 : failures->second);
  book.counter({"mbgate_listener_requests_total", "Requests of clients."}, labels(),
               counters.requests);
  book.counter({"mbgate_listener_over_rate_requests_total",
                "Requests refused because their client sent more than max_requests_per_second."},
               labels(), counters.over_rate);
  const MetricBook::Kind refused{
      "mbgate_listener_refused_requests_total",
      "Requests that the gateway itself answered with an exception, by its code."};
  for (const ExceptionReason& it : kExceptionReasons) {
    const auto add = [&](const char* kind, const bus::ExceptionCounts& counts) {
      book.counter(refused, labels({{"kind", kind}, {"code", it.digits}, {"reason", it.reason}}),
                   counts.of(it.code));
    };
    add("read", counters.refused_reads);
    add("write", counters.refused_writes);
  }
}

// Connections from one address to a listener are one client.
void add_clients(MetricBook& book, const std::vector<gateway::ClientStatus>& clients) {
  std::map<std::pair<std::string, std::string>, std::pair<double, double>> sums;
  for (const gateway::ClientStatus& client : clients) {
    auto& [requests, refused] = sums[{client.listener, client.address}];
    requests += static_cast<double>(client.requests);
    refused += static_cast<double>(client.refused);
  }
  for (const auto& [name, sum] : sums) {
    const Labels labels{{"listener", name.first}, {"client", name.second}};
    book.gauge({"mbgate_client_requests", "Requests on the open connections of the address."},
               labels, sum.first);
    book.gauge({"mbgate_client_refused_requests",
                "Of these, answered with an exception by the gateway itself."},
               labels, sum.second);
  }
}

}  // namespace

std::vector<prometheus::MetricFamily> metric_families(const gateway::StatusReport& report,
                                                      const ProcessStatus& process,
                                                      bool by_client) {
  MetricBook book;
  add_process(book, report, process);
  for (const gateway::ListenerStatus& listener : report.listeners) {
    add_listener(book, listener, process.tls_failures);
  }
  if (by_client) {
    add_clients(book, report.clients);
  }
  for (const gateway::BusStatus& bus : report.buses) {
    add_bus(book, bus);
  }
  add_devices(book, report);
  return book.take();
}

std::string metrics_text(const std::vector<prometheus::MetricFamily>& families) {
  return prometheus::TextSerializer().Serialize(families);
}

}  // namespace mbgate::app

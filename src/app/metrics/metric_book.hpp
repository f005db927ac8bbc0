// SPDX-License-Identifier: Apache-2.0
// Metrics while they are collected, by families, for Prometheus' text format.
#pragma once

#include <prometheus/metric_family.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bus/durations.hpp"
#include "gateway/status/status_report.hpp"

namespace mbgate::app {

/// Prometheus has seconds.
inline double seconds_of(bus::Duration duration) {
  return std::chrono::duration<double>(duration).count();
}

using Labels = std::vector<prometheus::ClientMetric::Label>;

class MetricBook {
 public:
  /// What metrics of one name have in common. The name ends as Prometheus has it: `_total` for
  /// counters, then the unit.
  struct Kind {
    const char* name;
    const char* help;  ///< one sentence
  };

  void counter(const Kind& kind, Labels labels, auto value) {
    add(kind, prometheus::MetricType::Counter, std::move(labels)).counter.value =
        static_cast<double>(value);
  }
  void gauge(const Kind& kind, Labels labels, auto value) {
    add(kind, prometheus::MetricType::Gauge, std::move(labels)).gauge.value =
        static_cast<double>(value);
  }
  void histogram(const Kind& kind, Labels labels, const bus::Histogram& histogram) {
    auto& shown = add(kind, prometheus::MetricType::Histogram, std::move(labels)).histogram;
    std::uint64_t sum = 0;
    for (std::size_t place = 0; place < histogram.counts().size(); ++place) {
      sum += histogram.counts()[place];
      const bool is_last = place == histogram.bounds().size();
      shown.bucket.push_back({sum, is_last ? std::numeric_limits<double>::infinity()
                                           : seconds_of(histogram.bounds()[place])});
    }
    shown.sample_count = sum;
    shown.sample_sum = seconds_of(histogram.sum());
  }

  /// In the order in which the families came first.
  std::vector<prometheus::MetricFamily> take() { return std::move(families_); }

 private:
  prometheus::ClientMetric& add(const Kind& kind, prometheus::MetricType type, Labels labels) {
    const auto [place, is_new] = places_.try_emplace(kind.name, families_.size());
    if (is_new) {
      families_.push_back({kind.name, kind.help, type, {}});
    }
    prometheus::ClientMetric& metric = families_[place->second].metric.emplace_back();
    metric.label = std::move(labels);
    return metric;
  }

  std::vector<prometheus::MetricFamily> families_;
  std::map<std::string, std::size_t> places_;
};

/// Why the gateway itself answers with an exception: one reason for each code.
struct ExceptionReason {
  std::uint8_t code;
  const char* digits;
  const char* reason;
};

constexpr std::array kExceptionReasons = {
    ExceptionReason{0x01, "01", "not_permitted"}, ExceptionReason{0x02, "02", "no_such_address"},
    ExceptionReason{0x03, "03", "malformed"},     ExceptionReason{0x04, "04", "word_order"},
    ExceptionReason{0x06, "06", "not_sent"},      ExceptionReason{0x0A, "0A", "no_path"},
    ExceptionReason{0x0B, "0B", "no_answer"},
};

/// Addresses of a bus that no [[device]] names are one, "other", without an address.
void add_devices(MetricBook& book, const gateway::StatusReport& report);

void add_bus(MetricBook& book, const gateway::BusStatus& bus);

}  // namespace mbgate::app

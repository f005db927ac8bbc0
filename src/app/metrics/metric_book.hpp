// SPDX-License-Identifier: Apache-2.0
// Metrics while they are collected, by families, for Prometheus' text format.
#pragma once

#include <prometheus/metric_family.h>

#include <chrono>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bus/histogram.hpp"

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

  void counter(const Kind& kind, Labels labels, double value);
  void gauge(const Kind& kind, Labels labels, double value);
  void histogram(const Kind& kind, Labels labels, const bus::Histogram& histogram);

  /// In the order in which the families came first.
  std::vector<prometheus::MetricFamily> take() { return std::move(families_); }

 private:
  prometheus::ClientMetric& add(const Kind& kind, prometheus::MetricType type, Labels labels);

  std::vector<prometheus::MetricFamily> families_;
  std::map<std::string, std::size_t> places_;
};

}  // namespace mbgate::app

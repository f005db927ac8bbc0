// SPDX-License-Identifier: Apache-2.0
#include "app/metrics/metric_book.hpp"

#include <limits>

namespace mbgate::app {
prometheus::ClientMetric& MetricBook::add(const Kind& kind, prometheus::MetricType type,
                                          Labels labels) {
  const auto [place, is_new] = places_.try_emplace(kind.name, families_.size());
  if (is_new) {
    families_.push_back({kind.name, kind.help, type, {}});
  }
  prometheus::ClientMetric& metric = families_[place->second].metric.emplace_back();
  metric.label = std::move(labels);
  return metric;
}

void MetricBook::histogram(const Kind& kind, Labels labels, const bus::Histogram& histogram) {
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

}  // namespace mbgate::app

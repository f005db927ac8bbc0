// SPDX-License-Identifier: Apache-2.0
// What Prometheus collects (docs/metrics.md): the state of the gateway in its text format. Names
// and units follow its conventions. Labels are names of the configuration; units without a
// [[device]] are counted together.
#pragma once

#include <prometheus/metric_family.h>

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "gateway/status/status_report.hpp"

namespace mbgate::app {

/// Of a [[tls]] in use.
struct CertificateStatus {
  std::string name;
  std::chrono::system_clock::time_point ends;
  /// Of the list of revoked certificates; none: there is no list.
  std::optional<std::chrono::system_clock::time_point> crl_ends{};
};

/// What the process reports in addition to the machine's status.
struct ProcessStatus {
  std::string version;
  std::string config;  ///< path of the configuration file
  std::chrono::system_clock::time_point config_read_at;
  bool reload_refused = false;  ///< the last one: the settings in force are older than the file
  std::string config_digest{};  ///< config_digest() of the configuration in force
  std::vector<CertificateStatus> certificates{};
  /// By listener: clients without a handshake, and those that a reload ended because of their
  /// certificates. Others: none.
  std::map<std::string, std::uint64_t> tls_failures{};
};

/// `by_client`: requests by the addresses of clients too, which nothing bounds but the number of
/// connections.
std::vector<prometheus::MetricFamily> metric_families(const gateway::StatusReport& report,
                                                      const ProcessStatus& process, bool by_client);

/// Of the process that asks: what the kernel counts of it.
std::vector<prometheus::MetricFamily> process_families();

std::string metrics_text(const std::vector<prometheus::MetricFamily>& families);

}  // namespace mbgate::app

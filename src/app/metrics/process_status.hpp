// SPDX-License-Identifier: Apache-2.0
// What the process reports in addition to the machine's status: version, configuration,
// certificates.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace mbgate::app {

/// Of a [[tls]] in use.
struct CertificateStatus {
  std::string name;
  std::chrono::system_clock::time_point ends;
  /// Of the list of revoked certificates; none: there is no list.
  std::optional<std::chrono::system_clock::time_point> crl_ends{};
};

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

}  // namespace mbgate::app

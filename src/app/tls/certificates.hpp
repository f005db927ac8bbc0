// SPDX-License-Identifier: Apache-2.0
// The journal's lines about certificates, revocation lists, and clients that TLS refuses.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "app/log.hpp"
#include "app/metrics/metrics.hpp"
#include "io/tls/load_tls.hpp"

namespace mbgate::app {

class Certificates {
 public:
  Certificates(boost::asio::io_context& context, Log& log) : timer_(context), log_(log) {}
  Certificates(const Certificates&) = delete;
  Certificates& operator=(const Certificates&) = delete;
  ~Certificates() = default;

  /// These are in use from now on: says what ends soon, and says it again every day.
  void use(io::TlsContexts contexts);
  void tell_refusal(const std::string& listener, const io::TlsPlace& place, const std::string& why);
  /// What a reload changes by reading files anew whose names are the same, for the journal. A line
  /// for each [[tls]] that is in both: "[[tls]] plant: crl 2026-11-27 ..., 2 revoked, 1A:... ->
  /// 2026-11-28 ..., 3 revoked, 9F:...". One that is in either alone is reported with its
  /// listeners.
  [[nodiscard]] std::vector<std::string> changes(const io::TlsContexts& next) const;
  [[nodiscard]] std::vector<CertificateStatus> status() const;
  /// Since the start, by listener.
  [[nodiscard]] const std::map<std::string, std::uint64_t>& failures() const { return failures_; }
  void stop() { timer_.cancel(); }

 private:
  void tell();

  boost::asio::steady_timer timer_;
  Log& log_;
  io::TlsContexts contexts_;
  std::map<std::string, std::uint64_t> failures_;
};

}  // namespace mbgate::app

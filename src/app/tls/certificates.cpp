// SPDX-License-Identifier: Apache-2.0
#include "app/tls/certificates.hpp"

#include <chrono>
#include <fmt/core.h>
#include <utility>

namespace mbgate::app {
namespace {

void add_change(std::string& all, const char* key, const std::string& old,
                const std::string& next) {
  if (old != next) {
    all += fmt::format("{}{} {} -> {}", all.empty() ? "" : ", ", key, old, next);
  }
}

}  // namespace

void Certificates::use(io::TlsContexts contexts) {
  contexts_ = std::move(contexts);
  timer_.cancel();
  if (!contexts_.empty()) {
    tell();
  }
}

void Certificates::tell() {
  for (const auto& warning : io::warnings_of(contexts_, std::chrono::system_clock::now())) {
    log_.write_limited(Level::warning, warning, warning, {.id = message_id::kCertificateEnds});
  }
  timer_.expires_after(std::chrono::hours(24));
  timer_.async_wait([this](const boost::system::error_code& error) {
    if (!error) {
      tell();
    }
  });
}

std::vector<std::string> Certificates::changes(const io::TlsContexts& next) const {
  std::vector<std::string> changes;
  for (const auto& [name, context] : next) {
    const auto known = contexts_.find(name);
    if (known == contexts_.end()) {
      continue;
    }
    const io::TlsContents& before = known->second->contents();
    const io::TlsContents& after = context->contents();
    std::string all;
    add_change(all, "certificate", before.certificate, after.certificate);
    add_change(all, "authorities", before.authorities, after.authorities);
    add_change(all, "crl", before.lists, after.lists);
    if (!all.empty()) {
      changes.push_back(fmt::format("[[tls]] {}: {}", name, all));
    }
  }
  return changes;
}

std::vector<CertificateStatus> Certificates::status() const {
  std::vector<CertificateStatus> all;
  for (const auto& [name, context] : contexts_) {
    all.push_back({name, context->dates().certificate_ends, context->dates().crl_ends});
  }
  return all;
}

void Certificates::tell_refusal(const std::string& listener, const io::TlsPlace& place,
                                const std::string& why) {
  ++failures_[listener];
  const std::string client = place.address.to_text();
  // Its first words say of which kind it is: many that are refused do not hide one that was ended.
  log_.write_limited(Level::warning,
                     fmt::format("tls refusal {}{}", listener, why.substr(0, why.find(':'))),
                     fmt::format("listener {}: client {}: {}", listener, client, why),
                     {.id = message_id::kTlsRefused, .client = client, .listener = listener});
}

}  // namespace mbgate::app

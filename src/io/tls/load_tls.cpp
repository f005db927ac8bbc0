// SPDX-License-Identifier: Apache-2.0
#include "io/tls/load_tls.hpp"

#include <algorithm>
#include <fmt/chrono.h>
#include <iterator>
#include <utility>

namespace mbgate::io {
namespace {

using std::chrono::system_clock;

/// Time enough to have a new certificate made and brought.
constexpr std::chrono::hours kAhead{30 * 24};

std::string date_text(system_clock::time_point time) {
  return fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(time));
}

bool is_used(const gateway::Settings& settings, std::size_t tls) {
  return std::ranges::any_of(settings.listeners, [tls](const gateway::ListenerSettings& listener) {
    return !listener.is_gone && listener.tls == tls;
  });
}

bool is_used_by_a_line(const gateway::Settings& settings, const gateway::TlsSettings& tls) {
  return std::ranges::any_of(settings.buses, [&](const auto& bus) {
    return bus.line.tls && bus.line.tls->certificate == tls.certificate;
  });
}

}  // namespace

LoadedTls load_tls(const gateway::Settings& settings, KeyCheck keys) {
  LoadedTls loaded;
  for (std::size_t i = 0; i < settings.tls.size(); ++i) {
    const gateway::TlsSettings& tls = settings.tls[i];
    const bool is_of_listener = is_used(settings, i);
    if (!is_of_listener && !is_used_by_a_line(settings, tls)) {
      continue;
    }
    // A line reads it anew whenever it connects, and says then what is wrong.
    const bool asks = is_of_listener && keys == KeyCheck::ask_signer;
    auto context = TlsContext::make(tls, asks ? settings.signer : std::string());
    if (context) {
      loaded.contexts.emplace(tls.name, *std::move(context));
    } else {
      (is_of_listener ? loaded.failures : loaded.warnings)
          .push_back(fmt::format("[[tls]] {}: {}", tls.name, context.error().why));
      loaded.is_wrong = loaded.is_wrong || (is_of_listener && !context.error().may_come);
    }
  }
  std::ranges::move(warnings_of(loaded.contexts, system_clock::now()),
                    std::back_inserter(loaded.warnings));
  return loaded;
}

std::vector<std::string> warnings_of(const TlsContexts& contexts, system_clock::time_point now) {
  std::vector<std::string> warnings;
  for (const auto& [name, context] : contexts) {
    const TlsDates& dates = context->dates();
    const std::string start = fmt::format("[[tls]] {}: the certificate ", name);
    if (dates.certificate_ends <= now) {
      warnings.push_back(fmt::format("{}expired at {}: the other end refuses it", start,
                                     date_text(dates.certificate_ends)));
    } else if (dates.certificate_ends <= now + kAhead) {
      warnings.push_back(fmt::format("{}expires at {}", start, date_text(dates.certificate_ends)));
    }
    if (dates.crl_ends && *dates.crl_ends <= now) {
      warnings.push_back(fmt::format(
          "[[tls]] {}: the list of revoked certificates expired at {}: it is still used, "
          "but lacks later revocations",
          name, date_text(*dates.crl_ends)));
    }
  }
  return warnings;
}

}  // namespace mbgate::io

// SPDX-License-Identifier: Apache-2.0
// Which denied requests the journal is told of, and what it is told. Reads, writes and stops are
// counted apart, so that none of them hides another.
#pragma once

#include <optional>

#include "gateway/access/report_limit.hpp"
#include "gateway/event.hpp"
#include "gateway/limits.hpp"
#include "gateway/settings/settings_snapshot.hpp"
#include "gateway/writes/write_rules.hpp"

namespace mbgate::gateway {

class DenialReports {
 public:
  /// The request was denied. Nothing if that is not to be reported.
  [[nodiscard]] std::optional<Event> note(const SettingsSnapshot& settings, const WriteRules& rules,
                                          const ClientInfo& client, const modbus::MbapAdu& request,
                                          Instant now);

 private:
  ReportLimit reads_{kDenialsReported};
  ReportLimit writes_{kDenialsReported};
  ReportLimit stops_{kActsReported};
};

}  // namespace mbgate::gateway

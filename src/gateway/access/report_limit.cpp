// SPDX-License-Identifier: Apache-2.0
#include "gateway/access/report_limit.hpp"

#include "gateway/limits.hpp"

namespace mbgate::gateway {

bool ReportLimit::is_over(const Minute& minute, bus::Instant now) {
  return minute.reports == 0 || now - minute.began >= kReportedEvery;
}

ReportLimit::Minute& ReportLimit::minute_of(Client client, bus::Instant now) {
  if (const auto known = minutes_.find(client); known != minutes_.end()) {
    return known->second;
  }
  if (minutes_.size() >= kReportedClients) {
    std::erase_if(minutes_, [now](const auto& entry) { return is_over(entry.second, now); });
  }
  return minutes_.size() < kReportedClients ? minutes_[std::move(client)] : of_others_;
}

std::optional<std::uint64_t> ReportLimit::note(const ClientInfo& client, bus::Instant now) {
  Minute& minute = minute_of({client.address.counted_as(), client.role.certificate}, now);
  if (is_over(minute, now)) {
    minute.began = now;
    minute.reports = 0;
  }
  if (minute.reports == per_minute_) {
    ++minute.left_out;
    return std::nullopt;
  }
  ++minute.reports;
  return std::exchange(minute.left_out, 0);
}

}  // namespace mbgate::gateway

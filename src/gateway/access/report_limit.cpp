// SPDX-License-Identifier: Apache-2.0
#include "gateway/access/report_limit.hpp"

#include "gateway/access/who.hpp"

namespace mbgate::gateway {
namespace {

bool is_stop(const SettingsSnapshot& settings, const WriteRules& rules, const ClientInfo& client,
             const modbus::MbapAdu& request) {
  const auto* route = settings.routes.find(client.listener, request.header.unit);
  if (route == nullptr || settings.settings.status_unit == request.header.unit) {
    return false;
  }
  const auto plan = routing::Plan::make_denied(*route, request.header.unit, request.pdu);
  return plan && rules.is_stop(*plan);
}

Denied denial_of(const SettingsSnapshot& settings, const ClientInfo& client,
                 const modbus::MbapAdu& request, std::uint64_t left_out) {
  const WhoAnswer answer = who_may(settings, client, request.header.unit, request.pdu);
  // --who does not know who has written last.
  return {asked_of(client, request),
          answer.permitted ? "denied by writer: another client writes now" : answer.by, left_out};
}

}  // namespace

ReportLimit::Minute& ReportLimit::minute_of(Client client, bus::Instant now) {
  if (const auto known = minutes_.find(client); known != minutes_.end()) {
    return known->second;
  }
  if (minutes_.size() >= kReportedClients) {
    std::erase_if(minutes_, [now](const auto& entry) { return entry.second.is_over(now); });
  }
  return minutes_.size() < kReportedClients ? minutes_[std::move(client)] : of_others_;
}

std::optional<std::uint64_t> ReportLimit::note(const ClientInfo& client, bus::Instant now) {
  Minute& minute = minute_of({client.address.counted_as(), client.role.certificate}, now);
  if (minute.is_over(now)) {
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

std::optional<Event> DenialReports::note(const SettingsSnapshot& settings, const WriteRules& rules,
                                         const ClientInfo& client, const modbus::MbapAdu& request,
                                         Instant now) {
  const auto report = [&]<typename Kind>(ReportLimit& limit, std::in_place_type_t<Kind>) {
    const auto left_out = limit.note(client, now);
    return left_out ? std::optional<Event>(Kind{denial_of(settings, client, request, *left_out)})
                    : std::nullopt;
  };
  if (modbus::is_read(request.pdu.bytes())) {
    return report(reads_, std::in_place_type<ReadDenied>);
  }
  return is_stop(settings, rules, client, request)
             ? report(stops_, std::in_place_type<StopDenied>)
             : report(writes_, std::in_place_type<WriteDenied>);
}

}  // namespace mbgate::gateway

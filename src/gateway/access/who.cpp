// SPDX-License-Identifier: Apache-2.0
#include "gateway/access/who.hpp"

#include <algorithm>
#include <fmt/core.h>

#include "gateway/access/rule_verdict.hpp"
#include "gateway/status_unit.hpp"
#include "gateway/writes/write_rules.hpp"
#include "routing/route.hpp"

namespace mbgate::gateway {
namespace {

using modbus::ExceptionCode;
using KeyName = DenyingKey::Name;

WhoAnswer denied(std::string by, ExceptionCode code, std::optional<DenyingKey> key = {}) {
  const std::string text = fmt::format(": exception {:02X}", static_cast<std::uint8_t>(code));
  return {false, "denied by " + std::move(by), text, key};
}

WhoAnswer refused(std::string by, std::optional<DenyingKey> key = {}) {
  return {false, "refused by " + std::move(by), ": the connection is closed at once", key};
}

WhoAnswer by_verdict(const RuleVerdict& verdict, const ClientInfo& client) {
  if (!verdict.permitted) {
    const bool by_rule = verdict.rule != nullptr;
    return denied(by_rule ? denied_by_text(verdict, client)
                          : "the access rules: " + denied_by_text(verdict, client),
                  ExceptionCode::illegal_function);
  }
  if (verdict.rule == nullptr) {
    return {true, "permitted: there are no rules"};
  }
  WhoAnswer answer{true, "permitted by rule " + verdict.rule->title()};
  if (verdict.other != nullptr) {
    answer.by += ", its reading by rule " + verdict.other->title();
  }
  for (const routing::AccessRule* rule : {verdict.rule, verdict.other}) {
    if (rule != nullptr && rule->per_second != 0) {
      answer.consequence +=
          fmt::format("; at most {} a second, stops excepted, else exception 06", rule->per_second);
    }
  }
  return answer;
}

// Of a route that is in the configuration; transparent listeners have others.
std::optional<DenyingKey> key_of_route(const SettingsSnapshot& settings,
                                       const routing::Route& route, KeyName name) {
  const auto& routes = settings.settings.routes;
  const auto found = std::ranges::find(routes, route);
  return found == routes.end()
             ? std::nullopt
             : std::optional(DenyingKey{name, static_cast<std::size_t>(found - routes.begin())});
}

DenyingKey key_of_listener(const ClientInfo& client, KeyName name) {
  return {name, static_cast<std::size_t>(client.listener)};
}

WhoAnswer by_read_only(const SettingsSnapshot& settings, const ClientInfo& client) {
  return denied("read_only of listener " + settings.settings.listener(client.listener).name,
                ExceptionCode::illegal_function, key_of_listener(client, KeyName::read_only));
}

WhoAnswer by_denial(const SettingsSnapshot& settings, const ClientInfo& client, std::uint8_t unit,
                    routing::Denial denial, const routing::Route& route) {
  constexpr auto kCode = ExceptionCode::illegal_function;
  const std::string of_route = fmt::format(" of the route of unit {}", unit);
  switch (denial) {
    case routing::Denial::functions:
      return denied("functions" + of_route, kCode,
                    key_of_route(settings, route, KeyName::functions));
    case routing::Denial::read_only_client: return by_read_only(settings, client);
    case routing::Denial::read_only_route:
      return denied("access" + of_route, kCode, key_of_route(settings, route, KeyName::access));
    case routing::Denial::no_broadcast:
      return denied("unit 0: only writes (5, 6, 15, 16) are broadcast", kCode);
  }
  return {};
}

// Why the plan could not be made.
WhoAnswer unplanned(const SettingsSnapshot& settings, const routing::ResolvedRoute& resolved,
                    ExceptionCode code, std::uint8_t unit, const modbus::Pdu& pdu) {
  const auto request = modbus::Request::parse(pdu);
  if (!request) {
    return denied("the standard: the request is malformed", code);
  }
  if (!routing::through_windows(resolved.route.windows, *request)) {
    return denied(fmt::format("the windows (registers) of the route of unit {}", unit), code,
                  key_of_route(settings, resolved.route, KeyName::windows));
  }
  return denied(resolved.device == nullptr
                    ? "the devices on the bus"
                    : "the limits and values of device " + resolved.device->name,
                code);
}

WhoAnswer by_writer(const SettingsSnapshot& settings, const ClientInfo& client,
                    const routing::Plan& plan, ExceptionCode code) {
  for (const auto& transaction : plan.transactions()) {
    for (const std::size_t place : settings.devices.reached_by(transaction)) {
      const DeviceGuard& guard = settings.guard(place);
      if (guard.writer == WriterRule::listed &&
          !guard.writers.contains(client.address, client.role)) {
        return denied("writer of device " + settings.settings.devices[place].name, code,
                      DenyingKey{KeyName::writer, place});
      }
    }
  }
  return denied("writer of a device", code);
}

WhoAnswer planned(const SettingsSnapshot& settings, const ClientInfo& client, std::uint8_t unit,
                  const routing::Plan& plan) {
  WhoAnswer answer = by_verdict(verdict_on(settings, client, unit, plan.asked(), &plan), client);
  const WriteRules rules(settings);
  if (!answer.permitted || plan.is_read() || rules.is_stop(plan)) {
    return answer;
  }
  const ClientKey key = key_of(client, settings.settings.listener(client.listener));
  const WriteOrigin origin{ClientId{}, client, key, Instant{}};
  if (const auto objection = rules.objection(plan, origin, Instant{})) {
    return by_writer(settings, client, plan, objection->code);
  }
  return answer;
}

}  // namespace

WhoAnswer who_may(const SettingsSnapshot& settings, const ClientInfo& client, std::uint8_t unit,
                  const modbus::Pdu& request) {
  const ListenerSettings& listener = settings.settings.listener(client.listener);
  if (!routing::lets_in(listener.allow, client.address)) {
    return refused("allow of listener " + listener.name, key_of_listener(client, KeyName::allow));
  }
  if (!may_connect(settings.settings, client)) {
    return refused("the access rules: none permits this address anything here");
  }
  const routing::ClientRights rights{listener.read_only.contains(client.address, client.role)};
  const RuleVerdict verdict = verdict_on(settings, client, unit, request, nullptr);
  if (settings.settings.status_unit == unit) {
    if (verdict.permitted && rights.read_only && !modbus::is_read(request.bytes())) {
      return by_read_only(settings, client);
    }
    const std::uint8_t function = request.function();
    return !verdict.permitted || function == 4 || function == 8 || function == 43
               ? by_verdict(verdict, client)
               : WhoAnswer{false, StatusUnit::kWhere, ": exception 01", {}};
  }
  const routing::ResolvedRoute* resolved = settings.routes.find(client.listener, unit);
  if (resolved == nullptr) {
    return verdict.permitted
               ? denied(fmt::format("the routes: unit {} has no route on this listener", unit),
                        ExceptionCode::gateway_path_unavailable)
               : by_verdict(verdict, client);
  }
  if (const auto denial = routing::denial_of(*resolved, rights, request)) {
    return by_denial(settings, client, unit, *denial, resolved->route);
  }
  const auto plan = routing::Plan::make(*resolved, unit, rights, request);
  if (plan) {
    return planned(settings, client, unit, *plan);
  }
  return verdict.permitted ? unplanned(settings, *resolved, plan.error(), unit, request)
                           : by_verdict(verdict, client);
}

}  // namespace mbgate::gateway

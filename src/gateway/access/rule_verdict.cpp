// SPDX-License-Identifier: Apache-2.0
#include "gateway/access/rule_verdict.hpp"

#include <algorithm>
#include <limits>

#include "gateway/limits.hpp"

namespace mbgate::gateway {
namespace {

using routing::AccessDecision;
using routing::AccessQuestion;
using routing::ClientRole;
using routing::StopIn;
using routing::TouchedRegisters;
using TouchedList = boost::container::small_vector<TouchedRegisters, 4>;

// What a request reads, and what it writes.
struct Halves {
  TouchedList read;
  TouchedList written;
};

bool is_denied_at_all(const ClientInfo& client) {
  return client.role.kind == ClientRole::Kind::unreadable;
}

// A stop is divided into what stops and its parameters.
void add_written(TouchedRegisters touched, const modbus::Request& request, TouchedList& written) {
  const modbus::TableRange whole = request.writes()->range;
  const drive::Device* device = touched.device;
  touched.range = whole;
  if (device == nullptr || !device->is_stop(request)) {
    const bool stops = device != nullptr && device->may_be_stopped_by(request);
    touched.stop = stops ? StopIn::some : StopIn::none;
    written.push_back(touched);
    return;
  }
  touched.range->count = 1;
  for (std::uint16_t place = 0; place < whole.count; ++place) {
    const auto address = static_cast<std::uint16_t>(whole.first + place);
    const auto stop = device->stop_at(request, address) != nullptr ? StopIn::all : StopIn::none;
    if (place > 0 && stop == written.back().stop) {
      ++written.back().range->count;
      continue;
    }
    touched.range->first = address;
    touched.stop = stop;
    written.push_back(touched);
  }
}

void add_of_device(const SettingsSnapshot& settings, std::optional<std::size_t> number,
                   const modbus::Request& request, Halves& halves) {
  const drive::Device* device = number ? &settings.settings.devices[*number] : nullptr;
  TouchedRegisters touched{number, device};
  if (const auto& reads = request.reads()) {
    touched.range = reads->range;
    halves.read.push_back(touched);
  }
  if (request.writes()) {
    touched.reconfigures = device != nullptr && device->is_reconfigured_by(request);
    add_written(touched, request, halves.written);
  }
  if (!request.reads() && !request.writes()) {
    (request.is_read() ? halves.read : halves.written).push_back(touched);
  }
}

Halves halves_of(const SettingsSnapshot& settings, const routing::Plan& plan) {
  Halves halves;
  for (const drive::Transaction& transaction : plan.transactions()) {
    if (transaction.must_hold != nullptr) {
      continue;  // the gateway's own question
    }
    const DevicePlaces places = settings.devices.reached_by(transaction);
    for (const std::size_t place : places) {
      add_of_device(settings, place, transaction.request, halves);
    }
    if (places.empty()) {
      add_of_device(settings, std::nullopt, transaction.request, halves);
    }
  }
  return halves;
}

// A broadcast is for all units that lead to its buses.
void add_reached(const SettingsSnapshot& settings, const routing::Plan& plan,
                 AccessQuestion& question) {
  const auto& sent = plan.transactions();
  if (!sent.back().broadcast) {
    return;
  }
  for (unsigned unit = 0; unit <= std::numeric_limits<std::uint8_t>::max(); ++unit) {
    const auto* resolved = settings.routes.find(question.listener, static_cast<std::uint8_t>(unit));
    if (resolved != nullptr && std::ranges::find_first_of(sent, resolved->route.buses, {},
                                                          &drive::Transaction::bus) != sent.end()) {
      question.reached.set(unit);
    }
  }
}

RuleVerdict verdict_on_halves(const Settings& settings, AccessQuestion question,
                              const Halves& halves) {
  RuleVerdict verdict;
  for (const bool is_read : {false, true}) {
    const TouchedList& touched = is_read ? halves.read : halves.written;
    if (touched.empty()) {
      continue;
    }
    question.is_read = is_read;
    question.touched = std::span(touched.data(), touched.size());
    const AccessDecision decision = routing::decide(settings.rules, question);
    if (!decision.permitted) {
      return {decision};
    }
    if (verdict.rule == nullptr) {
      verdict.rule = decision.rule;
    } else if (verdict.rule != decision.rule) {
      verdict.other = decision.rule;
    }
  }
  return verdict;
}

bool has_rate(const routing::AccessRule* rule) { return rule != nullptr && rule->per_second != 0; }

}  // namespace

bool may_connect(const Settings& settings, const ClientInfo& client) {
  const bool has_role = client.role.kind != ClientRole::Kind::none;
  const AccessQuestion question{client.address, has_role ? nullptr : &client.role, client.listener};
  return routing::decide(settings.rules, question).permitted;
}

RuleVerdict verdict_on(const SettingsSnapshot& settings, const ClientInfo& client,
                       std::uint8_t unit, const modbus::Pdu& request, const routing::Plan* plan) {
  if (is_denied_at_all(client)) {
    return {{false}};
  }
  if (settings.settings.rules.empty()) {
    return {};
  }
  AccessQuestion question{client.address, &client.role, client.listener,
                          unit,           {},           request.function()};
  question.reached.set(unit);
  if (plan != nullptr) {
    add_reached(settings, *plan, question);
    return verdict_on_halves(settings.settings, question, halves_of(settings, *plan));
  }
  const auto parsed = modbus::Request::parse(request);
  if (parsed && settings.settings.status_unit == unit) {
    Halves halves;
    add_of_device(settings, std::nullopt, *parsed, halves);
    return verdict_on_halves(settings.settings, question, halves);
  }
  question.is_read = modbus::is_read(request.bytes());
  return {routing::decide(settings.settings.rules, question)};
}

std::string denied_by_text(const RuleVerdict& verdict, const ClientInfo& client) {
  if (is_denied_at_all(client)) {
    return "the role in its certificate cannot be read";
  }
  return verdict.rule == nullptr ? "no rule permits it" : "rule " + verdict.rule->title();
}

bool AccessBook::take(const RuleVerdict& verdict, const ClientKey& client, Instant now) {
  if (!has_room(verdict.rule, client, now) || !has_room(verdict.other, client, now)) {
    return false;
  }
  for (const auto* rule : {verdict.rule, verdict.other}) {
    if (has_rate(rule)) {
      rates_[{rule, client}].take(rule->per_second, now);
    }
  }
  return true;
}

bool AccessBook::has_room(const routing::AccessRule* rule, const ClientKey& client, Instant now) {
  if (!has_rate(rule)) {
    return true;
  }
  const auto known = rates_.find({rule, client});
  if (known != rates_.end()) {
    return known->second.has_room(rule->per_second, now);
  }
  if (rates_.size() >= kRatedClients) {
    std::erase_if(rates_, [now](const auto& entry) { return entry.second.is_rested(now); });
  }
  return rates_.size() < kRatedClients;
}

}  // namespace mbgate::gateway

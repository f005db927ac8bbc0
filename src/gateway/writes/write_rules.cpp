// SPDX-License-Identifier: Apache-2.0
#include "gateway/writes/write_rules.hpp"

#include <algorithm>

namespace mbgate::gateway {

using modbus::ExceptionCode;

namespace {

// What is never allowed is said rather than what is not allowed now.
void add(std::optional<ExceptionCode>& found, const std::optional<ExceptionCode>& denied) {
  if (denied && found != ExceptionCode::illegal_function) {
    found = denied;
  }
}

}  // namespace

WriteRules::WriteRules(const SettingsSnapshot& settings)
    : settings_(&settings),
      stop_marks_(settings.settings.devices.size()),
      writers_(settings.settings.devices.size()) {}

bool WriteRules::is_stop(const routing::PlannedTransaction& transaction) const {
  return std::ranges::any_of(settings_->devices.addressed_by(transaction), [&](std::size_t place) {
    return settings_->settings.devices[place].is_stop(transaction.request);
  });
}

bool WriteRules::is_stop(const routing::Plan& plan) const {
  const auto part_stops = [this](const auto& it) { return is_stop(it); };
  const bool for_all = plan.transactions().back().broadcast.has_value();
  return !plan.is_read() && (for_all ? std::ranges::any_of(plan.transactions(), part_stops)
                                     : std::ranges::all_of(plan.transactions(), part_stops));
}

std::optional<ExceptionCode> WriteRules::objection(const routing::Plan& write,
                                                   const WriteOrigin& origin, Instant now) const {
  std::optional<ExceptionCode> found;
  for (const routing::PlannedTransaction& transaction : write.transactions()) {
    add(found, objection(transaction, origin, now));
  }
  return found;
}

std::optional<ExceptionCode> WriteRules::objection(const routing::PlannedTransaction& write,
                                                   const WriteOrigin& origin, Instant now) const {
  std::optional<ExceptionCode> found;
  for (const std::size_t place : settings_->devices.reached_by(write)) {
    const DeviceGuard* guard = settings_->guard(place);
    auto denied = guard == nullptr
                      ? std::nullopt
                      : writers_.objection(place, *guard, origin.info, origin.key, now);
    if (!denied && stop_marks_.forbids(place, origin.client, origin.arrival)) {
      denied = ExceptionCode::server_device_busy;
    }
    add(found, denied);
  }
  return found;
}

bool WriteRules::is_denied_by_writer(const routing::Plan& write, const WriteOrigin& origin,
                                     Instant now) const {
  return std::ranges::any_of(write.transactions(), [&](const auto& transaction) {
    const DevicePlaces places = settings_->devices.reached_by(transaction);
    return std::ranges::any_of(places, [&](std::size_t place) {
      const DeviceGuard* guard = settings_->guard(place);
      return guard != nullptr &&
             writers_.objection(place, *guard, origin.info, origin.key, now).has_value();
    });
  });
}

std::uint64_t WriteRules::note_accepted(const routing::Plan& request, const WriteOrigin& origin,
                                        Instant now) {
  ++sequence_;
  if (request.is_read()) {
    return sequence_;
  }
  if (is_stop(request)) {
    for (const routing::PlannedTransaction& part : request.transactions()) {
      for (const std::size_t place : settings_->devices.addressed_by(part)) {
        if (settings_->settings.devices[place].is_stop(part.request)) {
          stop_marks_.note(place, origin.client, sequence_, now);
        }
      }
    }
    return sequence_;
  }
  for (const routing::PlannedTransaction& part : request.transactions()) {
    for (const std::size_t place : settings_->devices.reached_by(part)) {
      writers_.note(place, origin.key, now);
    }
  }
  return sequence_;
}

bool WriteRules::was_stopped(const routing::Plan& write, std::uint64_t sequence) const {
  return !write.is_read() && std::ranges::any_of(write.transactions(), [&](const auto& part) {
    return std::ranges::any_of(settings_->devices.reached_by(part), [&](std::size_t place) {
      return stop_marks_.came_after(place, sequence);
    });
  });
}

void WriteRules::note_own_stop(std::size_t device, Instant now) {
  stop_marks_.note(device, std::nullopt, ++sequence_, now);
}

void WriteRules::adopt(const SettingsSnapshot& settings) {
  stop_marks_.adopt(settings.settings.devices);
  writers_.adopt(settings.settings.devices);
  settings_ = &settings;
}

std::optional<modbus::ExceptionCode> Writers::objection(std::size_t device,
                                                        const DeviceGuard& guard,
                                                        const ClientInfo& client,
                                                        const ClientKey& key,
                                                        bus::Instant now) const {
  const auto& owner = owners_[device];
  switch (guard.writer) {
    case WriterRule::any: return std::nullopt;
    case WriterRule::first:
      return owner && owner->client != key && now < owner->wrote + guard.writer_hold
                 ? std::optional(modbus::ExceptionCode::server_device_busy)
                 : std::nullopt;
    case WriterRule::listed:
      return guard.writers.contains(client.address, client.role)
                 ? std::nullopt
                 : std::optional(modbus::ExceptionCode::illegal_function);
  }
  return std::nullopt;
}

}  // namespace mbgate::gateway

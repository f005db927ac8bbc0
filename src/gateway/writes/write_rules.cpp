// SPDX-License-Identifier: Apache-2.0
#include "gateway/writes/write_rules.hpp"

#include <algorithm>
#include <utility>

namespace mbgate::gateway {

using modbus::ExceptionCode;

WriteRules::WriteRules(const SettingsSnapshot& settings)
    : settings_(&settings), known_(settings.settings.devices.size()) {}

bool WriteRules::is_stop(const routing::Plan& plan) const {
  const auto part_stops = [this](const drive::Transaction& part) {
    return std::ranges::any_of(settings_->devices.addressed_by(part), [&](std::size_t device) {
      return settings_->settings.devices[device].is_stop(part.request);
    });
  };
  const bool for_all = plan.transactions().back().broadcast.has_value();
  return !plan.is_read() && (for_all ? std::ranges::any_of(plan.transactions(), part_stops)
                                     : std::ranges::all_of(plan.transactions(), part_stops));
}

std::optional<WriteRules::Objection> WriteRules::objection(const routing::Plan& write,
                                                           const WriteOrigin& origin,
                                                           Instant now) const {
  std::optional<Objection> found;
  for (const drive::Transaction& transaction : write.transactions()) {
    for (const std::size_t device : settings_->devices.reached_by(transaction)) {
      const auto denied = objection(device, origin, now);
      if (denied &&
          (!found || (denied->by_writer && found->code != ExceptionCode::illegal_function))) {
        found = denied;
      }
    }
  }
  return found;
}

std::optional<WriteRules::Objection> WriteRules::objection(std::size_t device,
                                                           const WriteOrigin& origin,
                                                           Instant now) const {
  const Known& known = known_[device];
  const DeviceGuard& guard = settings_->guard(device);
  switch (guard.writer) {
    case WriterRule::any: break;
    case WriterRule::first:
      if (known.writer != origin.key && now < known.wrote_at + guard.writer_hold) {
        return Objection{ExceptionCode::server_device_busy, true};
      }
      break;
    case WriterRule::listed:
      if (!guard.writers.contains(origin.info.address, origin.info.role)) {
        return Objection{ExceptionCode::illegal_function, true};
      }
      break;
  }
  // What lies in a client's stream behind its own stop comes after it.
  const bool is_own_stop = known.stopped_by == origin.client;
  return origin.arrival < (is_own_stop ? known.others_at : known.stopped_at)
             ? std::optional(Objection{ExceptionCode::server_device_busy, false})
             : std::nullopt;
}

std::uint64_t WriteRules::note_accepted(const routing::Plan& request, const WriteOrigin& origin,
                                        Instant now) {
  ++sequence_;
  if (request.is_read()) {
    return sequence_;
  }
  const bool stops = is_stop(request);
  for (const drive::Transaction& part : request.transactions()) {
    const DeviceIndex& devices = settings_->devices;
    for (const std::size_t device : stops ? devices.addressed_by(part) : devices.reached_by(part)) {
      if (!stops) {
        known_[device].writer = origin.key;
        known_[device].wrote_at = now;
      } else if (settings_->settings.devices[device].is_stop(part.request)) {
        note_stop(known_[device], origin.client, now);
      }
    }
  }
  return sequence_;
}

bool WriteRules::was_stopped(const routing::Plan& write, std::uint64_t sequence) const {
  return !write.is_read() && std::ranges::any_of(write.transactions(), [&](const auto& part) {
    return std::ranges::any_of(settings_->devices.reached_by(part),
                               [&](std::size_t device) { return sequence < known_[device].stop; });
  });
}

void WriteRules::note_own_stop(std::size_t device, Instant now) {
  ++sequence_;
  note_stop(known_[device], std::nullopt, now);
}

void WriteRules::note_stop(Known& known, std::optional<ClientId> client, Instant now) const {
  if (known.stopped_by != client) {
    known.others_at = known.stopped_at;
    known.stopped_by = client;
  }
  known.stopped_at = now;
  known.stop = sequence_;
}

void WriteRules::adopt(const SettingsSnapshot& settings) {
  const auto old = std::exchange(known_, std::vector<Known>(settings.settings.devices.size()));
  for (std::size_t device = 0; device < old.size(); ++device) {
    if (const auto same = place_of_same_drive(settings_->settings, device, settings.settings)) {
      known_[*same] = old[device];
    }
  }
  settings_ = &settings;
}

}  // namespace mbgate::gateway

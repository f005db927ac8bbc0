// SPDX-License-Identifier: Apache-2.0
#include "bus/health/device_table.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace mbgate::bus {
namespace {

/// By address; empty: it has no device.
std::array<std::string, kAddresses> names_of(std::span<const drive::Device> devices) {
  std::array<std::string, kAddresses> names;
  for (const drive::Device& device : devices) {
    names.at(device.address) = device.name;
  }
  return names;
}

}  // namespace

TimesInForce DeviceEntry::in_force(const modbus::Request& request, bool hurries) const {
  TimesInForce found{device->timing_of(request)};
  Duration& timeout = found.timing.response_timeout;
  if (hurries) {
    const Duration usual = std::exchange(timeout, found.timing.probe_timeout_or_default());
    found.hurried_by = std::max(usual - timeout, Duration{0});
  }
  return found;
}

void DeviceEntry::forget_shown() {
  health.forget_shown();
  asked_at = second_at = second_read_at = Instant::min();
  silence = {};
  times = {};
}

DeviceTable::DeviceTable(const BusSettings& settings, std::span<const drive::Device> devices) {
  update(settings, devices);
}

Addresses DeviceTable::update(const BusSettings& settings, std::span<const drive::Device> devices) {
  const auto before = names_of(devices_);
  const auto names = names_of(devices);
  devices_.assign(devices.begin(), devices.end());
  other_.timing = settings.timing;
  longest_transaction_ = bus::longest_transaction(settings, devices);
  Addresses others;
  for (std::size_t address = 0; address < kAddresses; ++address) {
    DeviceEntry& entry = entries_.at(address);
    entry.device = &other_;
    entry.early_reported = false;
    entry.second_reported = false;
    entry.misfit_reported = entry.pause_reported = false;
    if (names.at(address) != before.at(address)) {
      others.set(address);
      entry.forget_shown();
    } else if (names.at(address).empty()) {
      entry.asked_at = Instant::min();  // perhaps nothing leads there any more
    }
  }
  for (const drive::Device& device : devices_) {
    entries_.at(device.address).device = &device;
  }
  forget_what_was_read();
  return others;
}

bool DeviceTable::is_stop(std::uint8_t address, const modbus::Request& request,
                          std::optional<drive::BroadcastForm> broadcast) const {
  if (!broadcast) {
    return entries_.at(address).device->is_stop(request);
  }
  return std::ranges::any_of(devices_, [&](const drive::Device& device) {
    return device.is_addressed_by(address, broadcast) && device.is_stop(request);
  });
}

void DeviceTable::hold_booting(const Transaction& broadcast, Instant now) {
  for (const drive::Device& device : devices_) {
    const auto boot_time = device.silent_after(broadcast.request);
    if (device.is_addressed_by(broadcast.address, broadcast.broadcast)) {
      entries_.at(device.address).hold_booting(boot_time, now);
    }
  }
}

void DeviceTable::note_written(const Transaction& broadcast) {
  for (const drive::Device& device : devices_) {
    if (device.is_addressed_by(broadcast.address, broadcast.broadcast)) {
      entries_.at(device.address)
          .hold.note_written(broadcast.request, device.is_stop(broadcast.request));
    }
  }
}

void DeviceTable::note_reconfiguring(const Transaction& transaction) {
  if (!transaction.request.writes()) {
    return;
  }
  for (const drive::Device& device : devices_) {
    const bool heard = transaction.is_broadcast() || device.address == transaction.address;
    if (heard && device.is_reconfigured_by(transaction.request)) {
      entries_.at(device.address).setting_known = false;
      entries_.at(device.address).setting.reset();
    }
  }
}

void DeviceTable::forget_what_was_read() {
  for (DeviceEntry& entry : entries_) {
    entry.setting_known = false;
    entry.setting.reset();
    entry.cache.clear();
  }
}

void DeviceTable::begin_write(const Job& write) {
  if (!write.is_broadcast()) {
    entries_.at(write.address()).cache.begin_write();
    return;
  }
  std::ranges::for_each(entries_, [](DeviceEntry& entry) { entry.cache.begin_write(); });
}

void DeviceTable::end_write(const Job& write) {
  if (!write.is_broadcast()) {
    entries_.at(write.address()).cache.end_write();
    return;
  }
  std::ranges::for_each(entries_, [](DeviceEntry& entry) { entry.cache.end_write(); });
}

void DeviceTable::take_over(DeviceTable& before) {
  for (std::size_t address = 0; address < kAddresses; ++address) {
    entries_.at(address).hold = std::move(before.entries_.at(address).hold);
    entries_.at(address).free_at = before.entries_.at(address).free_at;
  }
}

void DeviceTable::clear_counters() {
  for (DeviceEntry& entry : entries_) {
    entry.counters = {};
    entry.times = {};
  }
}

}  // namespace mbgate::bus

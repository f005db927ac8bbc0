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

void DeviceEntry::forget_shown() {
  health.forget_shown();
  asked_at = second_at = second_read_at = Instant::min();
  silence = {};
  times = {};
}

DeviceTable::DeviceTable(const BusSettings& settings, std::span<const drive::Device> devices) {
  unused_.device = &other_;
  update(settings, devices);
}

DeviceEntry& DeviceTable::add(std::uint8_t address) {
  return *(entries_.at(address) = std::make_unique<DeviceEntry>(unused_));
}

Addresses DeviceTable::update(const BusSettings& settings, std::span<const drive::Device> devices) {
  const auto before = names_of(devices_);
  const auto names = names_of(devices);
  devices_.assign(devices.begin(), devices.end());
  other_.timing = settings.timing;
  longest_transaction_ = bus::longest_transaction(settings, devices);
  Addresses others;
  for (std::size_t address = 0; address < kAddresses; ++address) {
    others[address] = names.at(address) != before.at(address);
    if (DeviceEntry* entry = entries_.at(address).get()) {
      entry->device = &other_;
      entry->early_reported = entry->second_reported = false;
      entry->misfit_reported = entry->pause_reported = false;
      if (others[address]) {
        entry->forget_shown();
      } else if (names.at(address).empty()) {
        entry->asked_at = Instant::min();  // perhaps nothing leads there any more
      }
    }
  }
  for (const drive::Device& device : devices_) {
    (*this)[device.address].device = &device;
  }
  forget_what_was_read();
  return others;
}

bool DeviceTable::is_stop(std::uint8_t address, const modbus::Request& request,
                          std::optional<drive::BroadcastForm> broadcast) const {
  if (!broadcast) {
    return (*this)[address].device->is_stop(request);
  }
  return std::ranges::any_of(devices_, [&](const drive::Device& device) {
    return device.is_addressed_by(address, broadcast) && device.is_stop(request);
  });
}

void DeviceTable::hold_booting(const Transaction& broadcast, Instant now) {
  for (const drive::Device& device : devices_) {
    const auto boot_time = device.silent_after(broadcast.request);
    if (device.is_addressed_by(broadcast.address, broadcast.broadcast)) {
      (*this)[device.address].hold_booting(boot_time, now);
    }
  }
}

void DeviceTable::note_written(const Transaction& broadcast) {
  for (const drive::Device& device : devices_) {
    if (device.is_addressed_by(broadcast.address, broadcast.broadcast)) {
      (*this)[device.address].hold.note_written(broadcast.request,
                                                device.is_stop(broadcast.request));
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
      (*this)[device.address].forget_setting();
    }
  }
}

void DeviceTable::forget_what_was_read() {
  for (DeviceEntry& entry : entries()) {
    entry.forget_setting();
    entry.cache.clear();
  }
}

void DeviceTable::note_write(const Job& write, void (ReadCache::*note)()) {
  if (!write.is_broadcast()) {
    ((*this)[write.address()].cache.*note)();
    return;
  }
  (unused_.cache.*note)();
  std::ranges::for_each(entries(), [note](DeviceEntry& entry) { (entry.cache.*note)(); });
}

void DeviceTable::take_over(DeviceTable& before) {
  for (std::size_t number = 0; number < kAddresses; ++number) {
    if (before.entries_.at(number)) {
      const auto address = static_cast<std::uint8_t>(number);
      (*this)[address].hold = std::move(before[address].hold);
      (*this)[address].free_at = before[address].free_at;
    }
  }
}

void DeviceTable::clear_counters() {
  for (DeviceEntry& entry : entries()) {
    entry.counters = {};
    entry.times = {};
  }
}

}  // namespace mbgate::bus

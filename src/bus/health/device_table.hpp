// SPDX-License-Identifier: Apache-2.0
// What a bus knows and remembers of each address on it.
#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

#include "bus/counters.hpp"
#include "bus/health/device_health.hpp"
#include "bus/job.hpp"
#include "bus/settings.hpp"
#include "bus/sharing/read_cache.hpp"
#include "bus/state_reader.hpp"

namespace mbgate::bus {

/// A serial line has 1 to 247, a downstream TCP bus 0 to 255.
inline constexpr std::size_t kAddresses = std::numeric_limits<std::uint8_t>::max() + 1;

struct DeviceEntry {
  const drive::Device* device = nullptr;  ///< never null
  DeviceCounters counters;
  DeviceHealth health;
  ReadCache cache;
  Instant free_at = Instant::min();  ///< nothing is sent to it before: it boots
  Job* probe = nullptr;              ///< the request that an offline device is asked with
  /// A setting of the device's own was found right (Transaction::must_hold), and since then nothing
  /// was unanswered, the line was not opened anew, and no communication register was written.
  bool setting_known = false;
  bool early_reported = false;
  std::uint64_t last_turn = 0;       ///< the last transmission to it that was no stop
  std::uint64_t last_stop_turn = 0;  ///< the last stop, if it left that unanswered; else 0
  bool stops_given_up = false;       ///< it left a stop and all repetitions unanswered
  bool merge_refused = false;        ///< it did not take a merged read
  bool second_reported = false;
  Instant owed_until = Instant::min();   ///< when the last unanswered request was due
  Instant answered_at = Instant::min();  ///< the last answer,
  std::uint8_t answered_function = 0;    ///< and the function that it answers

  [[nodiscard]] const drive::DeviceTiming& timing() const { return device->timing; }
  /// Something of it was heard: it is there.
  void note_heard() {
    last_stop_turn = 0;
    stops_given_up = false;
  }
};

class DeviceTable {
 public:
  /// Addresses that none of `devices` has get a device with the bus's own times.
  DeviceTable(const BusSettings& settings, std::span<const drive::Device> devices);
  DeviceTable(const DeviceTable&) = delete;  // its entries point to its devices
  DeviceTable& operator=(const DeviceTable&) = delete;

  /// Other devices, or other settings of them; what is known of their addresses stays.
  void update(const BusSettings& settings, std::span<const drive::Device> devices);
  [[nodiscard]] DeviceEntry& operator[](std::uint8_t address) { return entries_.at(address); }
  [[nodiscard]] const DeviceEntry& operator[](std::uint8_t address) const {
    return entries_.at(address);
  }
  [[nodiscard]] std::span<const drive::Device> devices() const { return devices_; }
  [[nodiscard]] std::span<const DeviceEntry> entries() const { return entries_; }
  /// Of all devices, and of addresses that have none.
  [[nodiscard]] Duration longest_response_timeout() const { return longest_response_timeout_; }
  /// Does a device at the address, or one that hears the broadcast, take this for a stop?
  [[nodiscard]] bool is_stop(std::uint8_t address, const modbus::Request& request,
                             drive::BroadcastForm broadcast) const;
  /// A broadcast has left: those that it makes boot hear nothing for a while.
  void hold_booting(const Transaction& broadcast, Instant now);
  /// A write is on its way that may change how a device is set.
  void note_reconfiguring(const Transaction& transaction);
  /// The line was opened anew: others may be there, or the same ones set otherwise.
  void forget_what_was_read();
  /// A write was accepted, or has ended: what was read from its device before is no answer to what
  /// is asked now.
  void begin_write(const Job& write);
  void end_write(const Job& write);
  void clear_counters();

 private:
  friend struct mbgate::StateReader;
  drive::Device other_;
  std::vector<drive::Device> devices_;
  Duration longest_response_timeout_{0};
  std::array<DeviceEntry, kAddresses> entries_{};
};

}  // namespace mbgate::bus

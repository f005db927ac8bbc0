// SPDX-License-Identifier: Apache-2.0
// What a bus knows of each address on it.
//
// To change
// - what is said of a line's quality (bad CRCs, no frames, late answers): line_quality; which
//   frames are another client's: LineDiagnosis::note_foreign().
// - late answers, quarantine, what is learned of how long and how late answers are: hold; offline
//   devices: device_health; where an answer begins to be owed: bus/transmission/outcomes; probes:
//   probes; frames that answer no pending request: line_diagnosis.
#pragma once

#include <algorithm>
#include <array>
#include <bitset>
#include <limits>
#include <memory>
#include <optional>
#include <ranges>
#include <span>
#include <vector>

#include "bus/counters.hpp"
#include "bus/durations.hpp"
#include "bus/health/device_health.hpp"
#include "bus/health/hold.hpp"
#include "bus/job.hpp"
#include "bus/settings.hpp"
#include "bus/transmission/read_cache.hpp"

namespace mbgate::bus {

/// A serial line has 1 to 255, a downstream TCP bus 0 to 255.
inline constexpr std::size_t kAddresses = std::numeric_limits<std::uint8_t>::max() + 1;
using Addresses = std::bitset<kAddresses>;

/// A stop that its device did not acknowledge.
struct FailedStop {
  Instant at;                  ///< when it was given up
  std::uint8_t exception = 0;  ///< with which it was refused; 0: it was unanswered
};

struct DeviceEntry {
  const drive::Device* device = nullptr;  ///< never null
  DeviceCounters counters;
  DeviceHealth health;
  Hold hold;
  ReadCache cache;
  Instant free_at = Instant::min();    ///< it boots, or pauses: only stops are sent to it before
  Job* probe = nullptr;                ///< the job that probes it while it is offline
  Instant probe_at = Instant::min();   ///< when the next one may be sent
  Instant wanted_at = Instant::min();  ///< when a request was last refused because it is offline
  /// The device's own setting was read and is as configured (Transaction::must_hold). Since then
  /// every request was answered, the line was not reopened, and no communication register was
  /// written.
  bool setting_known = false;
  bool early_reported = false;
  bool stop_unanswered = false;  ///< the last stop; what came may have been its echo
  bool stops_given_up = false;   ///< a stop and all its repetitions were unanswered
  bool second_reported = false;
  bool misfit_reported = false;
  bool pause_reported = false;
  Instant owed_until =
      Instant::min();                  ///< the end of the last response timeout with something owed
  Instant others_at = Instant::min();  ///< when another client's request to it was last heard
  /// Shown only, they decide nothing: when a request was last sent to it, what it has left
  /// unanswered since it was heard, and how long answers take.
  Instant asked_at = Instant::min();
  Silence silence;
  AnswerTimes times;
  /// Shown only, too: when a second answer to one request came, when the last one came that is no
  /// echo, of a read on a line whose echo was found before, and what the device's own setting
  /// (Transaction::must_hold) was when it was last read.
  Instant second_at = Instant::min();
  Instant second_read_at = Instant::min();
  std::optional<std::uint16_t> setting;
  /// Shown only: the exception of a server that did not reach it, if that came last.
  std::optional<std::uint8_t> unreached;
  /// And the last stop, if it was given up and no write was acknowledged since.
  std::optional<FailedStop> failed_stop;

  /// The times in force for the device, and for one request to it, which is a probe or a stop to an
  /// offline device if it `hurries`.
  [[nodiscard]] const drive::DeviceTiming& in_force() const { return device->timing; }
  [[nodiscard]] drive::DeviceTiming in_force(const modbus::Request& request, bool hurries) const {
    drive::DeviceTiming timing = device->timing_of(request);
    timing.response_timeout = hurries ? timing.probe_timeout_or_default() : timing.response_timeout;
    return timing;
  }
  /// No [[device]] has this address, and nobody was ever heard there.
  [[nodiscard]] bool is_unknown() const {
    return device->name.empty() && health.state() == DeviceState::not_asked;
  }
  /// What was sent to it last is unanswered, or there may be nobody.
  [[nodiscard]] bool is_silent() const {
    return health.state() == DeviceState::not_answering || health.is_offline() || is_unknown();
  }
  /// It was told what makes it boot, or may have been.
  void hold_booting(std::optional<Duration> boot_time, Instant now) {
    free_at = boot_time ? std::max(free_at, now + *boot_time) : free_at;
  }
  /// `gap_after_write`
  void hold_after(const modbus::Request& request, Instant now) {
    const Duration gap = request.is_read() ? Duration{0} : in_force().gap_after_write;
    free_at = gap > Duration{0} ? std::max(free_at, now + gap) : free_at;
  }
  void forget_setting() {
    setting_known = false;
    setting.reset();
  }
  /// A frame of the device was received: it is there.
  void note_heard() { stop_unanswered = stops_given_up = false; }
  /// Another device is at this address now. What is still owed there, and what is decided, stays.
  void forget_shown();
};

class DeviceTable {
 public:
  /// Addresses that none of `devices` has get a device with the bus's own times.
  DeviceTable(const BusSettings& settings, std::span<const drive::Device> devices);
  DeviceTable(const DeviceTable&) = delete;  // its entries point to its devices
  DeviceTable& operator=(const DeviceTable&) = delete;

  /// New devices, or new settings of them. What is known of their addresses is kept, but not what
  /// is shown of those that have a device of another name now, or none any more. Returns these.
  Addresses update(const BusSettings& settings, std::span<const drive::Device> devices);
  [[nodiscard]] DeviceEntry& operator[](std::uint8_t address) {
    const auto& entry = entries_.at(address);
    return entry ? *entry : add(address);
  }
  [[nodiscard]] const DeviceEntry& operator[](std::uint8_t address) const {
    const auto& entry = entries_.at(address);
    return entry ? *entry : unused_;
  }
  [[nodiscard]] std::span<const drive::Device> devices() const { return devices_; }
  /// Those of the devices, and of every other address that was ever used.
  [[nodiscard]] auto entries() const {
    return entries_ | std::views::filter([](const auto& entry) { return entry != nullptr; }) |
           std::views::transform([](const auto& entry) -> DeviceEntry& { return *entry; });
  }
  [[nodiscard]] Duration longest_transaction() const { return longest_transaction_; }
  /// Is the request a stop for the device at the address, or for a device that hears the broadcast?
  [[nodiscard]] bool is_stop(std::uint8_t address, const modbus::Request& request,
                             std::optional<drive::BroadcastForm> broadcast) const;
  /// A broadcast was sent. Devices that it restarts are left alone until they have booted.
  void hold_booting(const Transaction& broadcast, Instant now);
  /// A broadcast is being sent. For the devices that hear it, and whose stop it is not, it is a
  /// write like one to them alone (DeviceHealth::note_written).
  void note_written(const Transaction& broadcast);
  /// A write is being sent that may change a setting of a device.
  void note_reconfiguring(const Transaction& transaction);
  /// The line was reopened: there may be other devices on it, or the same ones with other settings.
  void forget_what_was_read();
  /// A write was accepted, or has ended (ReadCache::begin_write, end_write). What was read from its
  /// device before does not answer a request any more.
  void note_write(const Job& write, void (ReadCache::*note)());
  /// What is owed and was learned at each address, by a bus that had the same port before.
  void take_over(DeviceTable& before);
  void clear_counters();

 private:
  /// An address is used for the first time.
  DeviceEntry& add(std::uint8_t address);

  drive::Device other_;
  DeviceEntry unused_;  // what an address begins with: broadcasts are writes to it too
  std::vector<drive::Device> devices_;
  Duration longest_transaction_{0};
  std::array<std::unique_ptr<DeviceEntry>, kAddresses> entries_{};
};

}  // namespace mbgate::bus

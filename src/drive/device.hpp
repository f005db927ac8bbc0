// SPDX-License-Identifier: Apache-2.0
// A device: one server on a bus, with its profile and the settings that its user gives it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "drive/profile.hpp"

namespace mbgate::drive {

/// The number of a bus: its index in the settings.
enum class BusId : std::uint32_t {};

/// In place of the bus of a device that a reload has removed.
inline constexpr BusId kNoBus{std::numeric_limits<std::uint32_t>::max()};

struct DeviceTiming {
  /// From the computed end of transmission to the first byte of the response (Serial Line
  /// V1.02, 2.4.1).
  Duration response_timeout = std::chrono::seconds(1);
  /// How long the device itself holds its answer back: Autonics' "response waiting time" (register
  /// 405204), MOONS' "transmit delay" (TD). Added to the timeout.
  Duration response_wait{0};
  /// Extra silence before each request to this device.
  Duration gap{0};
  Duration gap_after_write{0};
  /// How often a read is repeated after a timeout or a bad CRC.
  unsigned retries = 1;
  /// Repeats writes too. A relative move that is repeated moves the axis twice.
  bool retry_writes = false;
  /// How often a stop is repeated that got no matching response.
  unsigned stop_retries = 3;
  /// For this long after the response timeout of its last unanswered transmission the device gets
  /// nothing but stops and the retry of the same read, because the answer may still come late.
  /// Default: one more response timeout.
  std::optional<Duration> quarantine{};
  /// The longest quarantine to which late responses can lead.
  Duration quarantine_max = std::chrono::seconds(10);
  /// After this many unanswered transmissions in a row the device is offline; 0: never.
  unsigned offline_after = 3;
  /// At most this often, one request is sent to an offline device as a probe.
  Duration probe_interval = std::chrono::seconds(2);
  /// The response timeout of a probe, at most half of the usual one. Default: 100 ms.
  std::optional<Duration> probe_timeout{};

  [[nodiscard]] Duration quarantine_or_default() const {
    return quarantine.value_or(response_timeout);
  }
  [[nodiscard]] Duration probe_timeout_or_default() const {
    return std::min(probe_timeout.value_or(std::chrono::milliseconds(100)), response_timeout / 2);
  }
};

struct Device {
  std::string name;
  BusId bus{};
  std::uint8_t address = 1;  ///< 1 to 255; on a downstream TCP bus 0 to 255
  DeviceTiming timing;
  /// Its values include those of the device itself (`values32`, `values64`).
  Profile profile{};
  /// The word order of the drive; none if it can be set and the configuration does not state it.
  std::optional<WordOrder> word_order{};
  /// The order of the position in MOONS' opcodes EP and SP.
  std::optional<WordOrder> opcode_order{};
  std::optional<std::uint8_t> write_function{};  ///< 6 or 16
  bool split_values = false;                     ///< a run of 06 may write a value half by half
  bool split_writes = false;                     ///< writes over the limit become several
  bool verify_word_order = false;
  bool limits_values = false;  ///< it limits what is written, and echoes what it made of it
  bool allow_reconfigure = false;
  /// Reads may be answered with data up to this old; 0: never.
  Duration cache{0};
  /// It is the Modbus TCP server itself: every unit identifier on its bus is this device.
  bool has_every_unit = false;

  /// A reload has removed it. Its number is not used again.
  [[nodiscard]] bool is_gone() const { return bus == kNoBus; }
  /// The times of this request: slow registers have a longer timeout.
  [[nodiscard]] DeviceTiming timing_of(const modbus::Request& request) const;
  /// Does the request write a communication register of the drive, or what its profile guards?
  [[nodiscard]] bool is_reconfigured_by(const modbus::Request& request) const {
    return is_reconfigured_by(request, word_order);
  }
  /// The same of a request whose values are in this order.
  [[nodiscard]] bool is_reconfigured_by(const modbus::Request& request,
                                        std::optional<WordOrder> order) const;
  /// Does a request to this address of its bus reach it?
  [[nodiscard]] bool stands_for(std::uint8_t to) const { return has_every_unit || to == address; }
  /// Does it carry out what goes to this address, or to all in this form of broadcasts?
  [[nodiscard]] bool is_addressed_by(std::uint8_t to, std::optional<BroadcastForm> form) const {
    return form ? profile.broadcast.hears(*form) : stands_for(to);
  }
  /// Does the request (05, 06, 15, 16) write nothing but values that stop the drive, and parameters
  /// of such a stop that it also writes?
  [[nodiscard]] bool is_stop(const modbus::Request& request) const;
  /// The stop that the request makes with what it writes to the address `place`; of several entries
  /// that fit, the one with the most parameters. nullptr: that does not stop the drive.
  [[nodiscard]] const WriteMatch* stop_at(const modbus::Request& request,
                                          std::uint32_t place) const;
  /// Does the response to a write say that the drive has carried it out, or does so?
  [[nodiscard]] bool has_accepted(const modbus::Pdu& response) const {
    return !response.is_exception() || profile.acceptances.test(response.bytes()[1]);
  }
  /// Does it write one of them, alone or among others? Function 22 writes only some bits of a
  /// register: what it makes of one that can stop may be a stop.
  [[nodiscard]] bool may_be_stopped_by(const modbus::Request& request) const;
  /// Does a request that was planned for `other` mean the same to this device?
  [[nodiscard]] bool understands_as(const Device& other) const {
    return word_order == other.word_order && opcode_order == other.opcode_order &&
           profile == other.profile;
  }
  /// The values of the profile's word order register that stand for the configured word order;
  /// nullptr if the profile names no such register.
  [[nodiscard]] const std::vector<std::uint16_t>* stated_order() const;
  /// Is the response the echo of a write of one register or coil, but for a value that the device
  /// has limited, and does it do that?
  [[nodiscard]] bool takes_limited(const modbus::Request& request, modbus::Bytes response) const;
  /// The boot time that follows a request which is never answered; nothing for others.
  [[nodiscard]] std::optional<Duration> silent_after(const modbus::Request& request) const;

  /// Does the request write any value (32 or 64 bits), or a part of one?
  [[nodiscard]] bool writes_value(const modbus::Request& request) const;
  /// Does the range hold a part of a value at one of its ends?
  [[nodiscard]] bool cuts_value(const modbus::TableRange& range) const;
  /// Does the request write an opcode whose position parameter has an unknown word order, for a
  /// client that sees values in the order `seen`? If the order is configured (`opcode_order`), the
  /// position is certain when it is written together with its opcode.
  [[nodiscard]] bool has_uncertain_position(WordOrder seen, const modbus::Request& request) const;
  /// The registers that a 16 or 23 writes, in the drive's word order. Where the client's order
  /// `seen` differs, values are exchanged, and so is the position of an opcode whose order is
  /// configured.
  [[nodiscard]] std::vector<std::uint8_t> data_in_order(std::optional<WordOrder> seen,
                                                        const modbus::Request& request) const;
};

}  // namespace mbgate::drive

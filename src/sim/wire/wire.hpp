// SPDX-License-Identifier: Apache-2.0
// A virtual RS-485 bus: the gateway's adapter at one end, drives along the line. Time is handed in;
// between two calls nothing happens, and in virtual time every byte has its exact instant.
//
//   wire.transmit(frame, now);                            // the gateway begins to transmit
//   while (auto at = wire.next_event()) {                 // jump from event to event
//     auto received = wire.advance(*at);                  // what the adapter hands over until then
//   }
//
// The drives accept only what comes at their baud rate and in their format; set_port() says how the
// gateway's port is set. Transmissions that overlap on the line are damaged for every receiver, and
// counted. A transmission of the gateway that begins before the line was silent for the configured
// gap is counted too. ASCII frames have their own end and need no silence.
//
// To change
// - a simulated line: modes, echo, collisions: wire, wire_frames; how a pty is set:
//   sim/program/pty.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "bus/instant.hpp"
#include "modbus/rtu_timing.hpp"
#include "sim/drives/device.hpp"
#include "sim/wire/request_framer.hpp"

namespace mbgate::sim {

enum class Clocking : std::uint8_t {
  /// Instants are exact: frames end by silence, and the gap before every transmission is checked.
  virtual_time,
  /// Instants are those of a busy machine: each transmission is one whole frame, and the gap is
  /// checked only after an answer, whose end the wire itself determines.
  real_time
};

/// How a serial port is set.
struct PortMode {
  modbus::Baud baud{115200};
  modbus::CharacterFormat format{8, modbus::Parity::none, 1};
  friend bool operator==(const PortMode&, const PortMode&) = default;
};

/// Does a receiver with this mode understand a sender with that mode? Their rates may differ by 2
/// %.
bool understands(const PortMode& receiver, const PortMode& sender);

struct WireSettings {
  modbus::Baud baud{115200};
  modbus::CharacterFormat format{8, modbus::Parity::none, 1};
  Framing framing = Framing::rtu;
  /// Silence between frames; default: t3.5; on unpaced buses none. ASCII has none.
  std::optional<Duration> gap{};
  Duration adapter_latency{
      0};  ///< the adapter hands over what it received so long after the first byte
  Duration chunk =
      std::chrono::milliseconds(1);  ///< least time between two deliveries; 0: each byte
  bool echo = false;                 ///< the gateway receives its own transmissions
  /// The delay of an echo after the wire. What comes behind an echo waits for it.
  Duration echo_delay{0};
  bool paced = true;  ///< false: characters take no time
  Clocking clocking = Clocking::virtual_time;
  std::size_t frames_kept = 0;  ///< the newest of the gateway's frames, for frames()
};

struct WireCounters {
  std::uint64_t frames = 0;  ///< of the gateway, damaged ones included
  std::uint64_t answers = 0;
  std::uint64_t silence_violations = 0;
  std::uint64_t collisions = 0;  ///< pairs of transmissions that overlap
  /// Frames of the gateway that reached the devices damaged, or not in their mode.
  std::uint64_t bad_crc = 0;
  friend bool operator==(const WireCounters&, const WireCounters&) = default;
};

/// A frame of the gateway as the devices received it.
struct FrameOnWire {
  Instant begin;
  Instant end;  ///< of its last character
  std::vector<std::uint8_t> bytes{};
  bool intact = false;                   ///< its mode, and its CRC or LRC are right
  std::vector<std::uint8_t> heard_by{};  ///< addresses of the devices that took it
};

/// What the gateway or a device transmits, as long as anybody has yet to hear of it.
struct TransmissionOnWire {
  Instant begin;
  Instant end;
  std::vector<std::uint8_t> bytes;
  bool from_gateway;
  bool understood = true;  ///< sent in the mode of its receivers
  bool framed = false;     ///< it was handed to the devices
  bool continued = false;  ///< the gateway's next transmission belongs to the same frame
  std::size_t delivered = 0;
  std::size_t next_count = 1;  ///< how many bytes will have been delivered at next_delivery
  Instant next_delivery{};
};

class Wire {
 public:
  Wire(const WireSettings& settings, const std::vector<DeviceSettings>& devices);

  /// Sets the mode of the gateway's port from now on; at first it is that of the devices.
  void set_port(const PortMode& mode);
  /// The gateway transmits `bytes` contiguously from `begin` on, or from the end of its own
  /// transmission that is still under way.
  void transmit(modbus::Bytes bytes, Instant begin);
  /// When something happens next without the gateway; nothing if the line will stay silent.
  [[nodiscard]] std::optional<Instant> next_event() const;
  /// Lets everything up to `now` happen; returns what the adapter hands over meanwhile, in order.
  std::vector<std::uint8_t> advance(Instant now);
  /// The adapter is unplugged: what is on the line is lost. Devices keep their state.
  void disconnect();

  [[nodiscard]] const WireSettings& settings() const { return settings_; }
  [[nodiscard]] const WireCounters& counters() const { return counters_; }
  [[nodiscard]] const std::deque<FrameOnWire>& frames() const { return frames_; }
  /// The device at `address`, nullptr if there is none.
  [[nodiscard]] Device* device(std::uint8_t address);
  [[nodiscard]] std::vector<Device>& devices() { return devices_; }

 private:
  using Transmission = TransmissionOnWire;

  [[nodiscard]] Duration time_of(std::size_t characters, bool from_gateway) const;
  [[nodiscard]] bool is_heard(const Transmission& transmission) const;
  [[nodiscard]] std::optional<Instant> event_of(const Transmission& transmission) const;
  void check_silence(Instant begin);
  void put_on_wire(Transmission transmission);
  void collide(Transmission& one, Transmission& other);
  void garble(Transmission& transmission, Instant from, Instant to) const;
  void step(Instant at);
  void deliver(Transmission& transmission);
  void plan_delivery(Transmission& transmission);
  void close_frames(Instant at);
  void close_ascii_frames(Instant at);
  void hand_to_devices(FrameOnWire frame);
  void let_answer(FrameOnWire& frame);
  void forget_what_is_over();

  WireSettings settings_;
  modbus::RtuTiming timing_;
  PortMode port_;
  modbus::RtuTiming port_timing_;
  Duration silence_;
  std::vector<Device> devices_;
  std::deque<Transmission> on_wire_;
  AsciiFramer ascii_;
  std::optional<Instant> last_end_;  ///< of transmissions already removed
  bool last_was_answer_ = false;
  std::vector<std::uint8_t> held_;  ///< in the adapter
  Instant held_until_{};
  Instant echo_until_{};  ///< when the last echo will have been handed over
  std::vector<std::uint8_t> received_;
  std::deque<FrameOnWire> frames_;
  WireCounters counters_;
};

}  // namespace mbgate::sim

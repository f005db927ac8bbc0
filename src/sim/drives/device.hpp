// SPDX-License-Identifier: Apache-2.0
// A drive on a virtual bus: a model at an address, with the faults that a test sets. It takes
// complete frames, as its UART would frame them, and says what it answers and how long that takes.
//
// To change
// - a simulated drive: *_drive, maps/*_map.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "bus/instant.hpp"
#include "sim/drives/aic_drive.hpp"
#include "sim/drives/fda6000_drive.hpp"
#include "sim/drives/moons_drive.hpp"
#include "sim/drives/stepper_drive.hpp"
#include "sim/wire/request_framer.hpp"

namespace mbgate::sim {

using bus::Instant;

enum class ModelKind : std::uint8_t { moons, stepper, aic, fda6000 };

/// None of them is random: the same requests get the same faults.
struct Faults {
  bool silent = false;  ///< receives nothing, answers nothing
  /// Time from the end of the request to the answer, instead of all other delays.
  std::optional<Duration> answer_after{};
  bool bad_crc = false;
  bool wrong_unit = false;      ///< answers with the next address
  bool wrong_function = false;  ///< answers with the next function code
  /// One of this many requests is refused with exception 04; 0: never.
  unsigned exception_every = 0;
};

/// Names and meanings are those of the simulator's configuration.
struct DeviceSettings {
  std::string name{};
  std::uint8_t address = 1;  ///< 1 to 247; on a TCP bus 0 to 255
  ModelKind model = ModelKind::moons;
  drive::WordOrder word_order = drive::WordOrder::big;  ///< MOONS' only
  MoonsSeries series = MoonsSeries::st;                 ///< MOONS' only
  /// For an AiC in whole milliseconds, 1 to 99. Default: none; for an AiC 1 ms.
  std::optional<Duration> response_wait{};
  std::optional<Duration> processing{};  ///< default: 1 ms; on unpaced buses none
  Faults faults{};
};

/// The same settings, with the default processing time if they have none.
DeviceSettings with_processing(DeviceSettings settings, bool paced);

/// When an answer begins.
struct AnswerTime {
  Duration after;  ///< between the end of the request's frame and the first byte
  /// `after` counts from the last byte of the request, the silence that ends the frame included.
  bool counts_from_end;
};

/// An answer without its framing.
struct Reply : AnswerTime {
  modbus::RtuAdu adu;
};

/// An answer as it goes onto the line.
struct Answer : AnswerTime {
  FrameBytes frame;
};

class Device {
 public:
  explicit Device(const DeviceSettings& settings, Framing framing = Framing::rtu);

  /// Takes a frame that ended at `end` and returns the answer. Nothing if the frame is not for this
  /// device, is damaged, or is not answered.
  std::optional<Answer> receive(modbus::Bytes frame, Instant end);
  /// The same without framing.
  std::optional<Reply> receive(const modbus::RtuAdu& adu, Instant end);

  [[nodiscard]] const DeviceSettings& settings() const { return settings_; }
  /// From the next frame on.
  void set_faults(const Faults& faults) { settings_.faults = faults; }
  /// Undamaged frames that it received, broadcasts included.
  [[nodiscard]] std::uint64_t heard() const { return heard_; }

  /// The drive behind the address; nullptr if it is of another kind.
  template <typename Drive>
  [[nodiscard]] Drive* drive() {
    return std::get_if<Drive>(&model_);
  }

 private:
  using Model = std::variant<MoonsDrive, StepperDrive, AicDrive, Fda6000Drive>;
  static Model make_model(const DeviceSettings& settings);
  [[nodiscard]] std::uint8_t broadcast_address() const;
  Reaction hear_broadcast(const modbus::Pdu& pdu);
  Reaction react(const modbus::RtuAdu& adu, bool busy);
  [[nodiscard]] Reply spoil(const modbus::Pdu& response, Duration delay) const;

  DeviceSettings settings_;
  Framing framing_;
  Model model_;
  Instant deaf_until_{};
  Instant busy_until_{};
  std::uint64_t heard_ = 0;
  std::uint64_t addressed_ = 0;
};

}  // namespace mbgate::sim

// SPDX-License-Identifier: Apache-2.0
// Small plants: one RTU line, two devices that are alike, two clients. They differ in a few
// settings.
#pragma once

#include <string_view>
#include <vector>

#include "gateway/settings.hpp"

namespace mbgate::explore {

using namespace std::chrono_literals;

inline constexpr std::uint8_t kDevices = 2;
inline constexpr std::uint8_t kClients = 2;

/// What is asked for. Answers to the two reads are alike, and so are those to the write and the
/// stop.
enum class Word : std::uint8_t { read_a, read_b, write, stop };
inline constexpr std::uint8_t kWords = 4;

/// Where they lie; the write and the stop are both by 16 to the same register.
inline constexpr std::uint16_t kRegisterA = 0x0000;
inline constexpr std::uint16_t kRegisterB = 0x0008;
inline constexpr std::uint16_t kCommand = 0x0010;
inline constexpr std::uint16_t kStopValue = 0x00E1;
inline constexpr std::uint16_t kFirstValue = 0x0100;  ///< of writes, each with one of its own

struct Plant {
  std::string_view name;
  std::string_view what;
  gateway::Settings settings;

  [[nodiscard]] const bus::BusSettings& bus() const { return settings.buses.front(); }
  [[nodiscard]] const drive::Device& device() const { return settings.devices.front(); }
};

const std::vector<Plant>& plants();
/// Nothing: there is none of this name.
const Plant* find_plant(std::string_view name);

}  // namespace mbgate::explore

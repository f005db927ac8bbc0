// SPDX-License-Identifier: Apache-2.0
// What a serial line may be told, but is told by a slip of the finger more often than not.
#include <array>
#include <cmath>

#include "config/sections.hpp"

namespace mbgate::config {
namespace {

/// What Linux has names for from 300 baud on (termios.h), and what else UARTs and drives offer.
constexpr std::array<std::uint32_t, 30> kUsualRates = {
    300,    600,    1200,   1800,   2400,    4800,    9600,    14400,   19200,   28800,
    38400,  56000,  57600,  76800,  115200,  125000,  128000,  230400,  250000,  256000,
    460800, 500000, 576000, 921600, 1000000, 1152000, 1500000, 2000000, 3000000, 4000000};

/// By ratio, as a wrong digit changes a rate.
std::uint32_t nearest_rate(std::uint32_t rate) {
  const auto distance = [rate](std::uint32_t usual) {
    return std::abs(std::log(static_cast<double>(rate) / static_cast<double>(usual)));
  };
  return std::ranges::min(kUsualRates, {}, distance);
}

void check_rate(TomlTable& table, const bus::LineSettings& line) {
  const auto rate = static_cast<std::uint32_t>(line.baud);
  if (std::ranges::find(kUsualRates, rate) == kUsualRates.end()) {
    table.warning("baud", std::to_string(rate) + " is no usual rate; did you mean " +
                              std::to_string(nearest_rate(rate)) + "?");
  }
}

/// "./line-a" says itself that it is meant.
void check_path(TomlTable& table, const bus::LineSettings& line) {
  const std::string_view device = line.device;
  const bool relative = !device.empty() && !device.starts_with('/') && !device.starts_with("./") &&
                        !device.starts_with("../") && device.find("://") == std::string_view::npos;
  if (relative) {
    table.warning("device", in_quotes(device) +
                                " lies below the folder that mbgated is started in; did you mean " +
                                in_quotes("/dev/" + line.device) + "?");
  }
}

}  // namespace

void check_habits(TomlTable& table, const bus::LineSettings& line) {
  check_rate(table, line);
  check_path(table, line);
}

}  // namespace mbgate::config

// SPDX-License-Identifier: Apache-2.0
// Warnings of values of a serial line that are valid, but more often a slip of the finger.
#include <array>
#include <cmath>

#include "config/sections/sections.hpp"

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

/// ttyS0, ttyUSB0, ttyACM0, ttyAMA0, ttymxc0: what the kernel calls a serial port.
bool is_kernel_name(std::string_view name) {
  return name.starts_with("tty") && name.back() >= '0' && name.back() <= '9';
}

/// Where a device of this relative path will be.
std::string below_dev(std::string_view path) {
  const auto name = path.substr(path.rfind('/') + 1);
  if (is_kernel_name(name)) {
    return "/dev/" + std::string(name);
  }
  constexpr std::string_view kDev = "dev/";
  return "/dev/" + std::string(path.substr(path.starts_with(kDev) ? kDev.size() : 0));
}

/// "./line-a" says itself that it is meant; "./ttyUSB0" is what a shell in /dev completes.
bool is_meant(std::string_view path) {
  return (path.starts_with("./") || path.starts_with("../")) &&
         !is_kernel_name(path.substr(path.rfind('/') + 1));
}

void check_path(TomlTable& table, const bus::LineSettings& line) {
  const std::string_view device = line.device;
  const bool relative =
      !device.empty() && !device.starts_with('/') && device.find("://") == std::string_view::npos;
  if (relative && !is_meant(device)) {
    table.warning("device", in_quotes(device) +
                                " is looked for from the folder that mbgated is started in; did "
                                "you mean " +
                                in_quotes(below_dev(device)) + "?");
  }
}

}  // namespace

void check_habits(TomlTable& table, const bus::LineSettings& line) {
  check_rate(table, line);
  check_path(table, line);
}

}  // namespace mbgate::config

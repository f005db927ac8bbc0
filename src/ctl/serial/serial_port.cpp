// SPDX-License-Identifier: Apache-2.0
#include "ctl/serial/serial_port.hpp"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fmt/format.h>
#include <ranges>
#include <system_error>

#include "base/text.hpp"
#include "config/toml/match_entry.hpp"

namespace mbgate::ctl {
namespace {

sys::TtyMode raw_mode(const LineMode& mode) {
  const auto parity = mode.format.parity == modbus::Parity::none   ? sys::TtyParity::none
                      : mode.format.parity == modbus::Parity::even ? sys::TtyParity::even
                                                                   : sys::TtyParity::odd;
  // The CRC of a character with the wrong parity is to fail: a drive that does not look at the
  // parity of the request must not pass for one that has it.
  return {static_cast<std::uint32_t>(mode.baud), 8, parity, mode.format.stop_bits, true};
}

using modbus::Parity;

constexpr std::uint32_t kFastestLine = 4'000'000;  // no UART of Linux has a faster one

/// What `parse` makes of each word of a list with commas; nothing if it makes nothing of one.
template <typename Parse>
auto parse_list(std::string_view text, Parse parse) {
  std::vector<typename decltype(parse(text))::value_type> all;
  for (const auto word : std::views::split(text, ',')) {
    const auto one = parse(std::string_view(word.begin(), word.end()));
    if (!one) {
      return std::optional<decltype(all)>();
    }
    all.push_back(*one);
  }
  return all.empty() ? std::nullopt : std::optional(std::move(all));
}

std::optional<std::uint32_t> number_of(std::string_view text, std::uint32_t most) {
  const auto number = integer_in<std::uint32_t>(text);
  return number >= 1U && *number <= most ? number : std::nullopt;
}

}  // namespace

SerialPort::~SerialPort() {
  if (!fd_.is_open()) {
    return;
  }
  if (before_) {
    sys::discard_all(fd_.get());  // else close() waits for what a failing adapter never sends
    sys::restore_tty_settings(fd_.get(), *before_);
  }
  sys::release_tty(fd_.get());
}

Result<SerialPort, int> SerialPort::open(const std::string& device) {
  sys::UniqueFd fd = sys::open_tty(device);
  if (!fd.is_open()) {
    return errno;
  }
  return SerialPort(std::move(fd));
}

std::optional<std::string> SerialPort::set_mode(const LineMode& mode) {
  if (!before_) {
    before_ = sys::read_tty_settings(fd_.get());
  }
  const sys::TtyMode wanted = raw_mode(mode);
  const auto real = sys::set_tty_mode(fd_.get(), wanted);
  if (!real) {
    return "the driver refuses it: " + std::generic_category().message(errno);
  }
  if (!real->has_rate_near(wanted.baud)) {
    return fmt::format("the driver took {} baud instead", real->baud);
  }
  // A pseudo-terminal has no parity, and is not asked for what became of it.
  if (!real->has_format_of(wanted) && !sys::is_pseudo_terminal(fd_.get())) {
    return "the driver took another parity, or other stop bits, instead";
  }
  sys::discard_all(fd_.get());
  return std::nullopt;
}

std::string port_failure(const std::string& device, int error,
                         const std::vector<std::string>& names) {
  switch (error) {
    case EBUSY:
      return fmt::format(
          "a gateway or another program holds {}: stop it first (systemctl stop mbgated), or scan "
          "through it with --host and --port",
          device);
    case ENOTTY: return device + ": this is not a serial port";
    case EACCES:
      return fmt::format(
          "you may not open {}: your user must be in the group dialout (sudo adduser NAME dialout, "
          "then log in again)",
          device);
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return fmt::format("there is no serial port {}{}{}", device,
                         names.empty() ? "" : "; there is ", fmt::join(names, ", "));
    default:
      return fmt::format("cannot open {}: {}", device, std::generic_category().message(error));
  }
}

std::vector<std::string> paths_in(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    names.push_back(entry->path().string());
  }
  std::ranges::sort(names);
  return names;
}

std::optional<std::string> lasting_name(const std::string& device,
                                        const std::vector<std::string>& names) {
  // Not by equivalent(), which does not compare devices.
  std::error_code error;
  const auto port = std::filesystem::canonical(device, error);
  const auto leads_there = [&](const std::string& name) {
    std::error_code broken;
    const auto end = std::filesystem::canonical(name, broken);
    return !error && !broken && end == port;
  };
  if (std::ranges::find(names, device) != names.end()) {
    return std::nullopt;
  }
  const auto found = std::ranges::find_if(names, leads_there);
  return found == names.end() ? std::nullopt : std::optional(*found);
}

std::string mode_text(const LineMode& mode) {
  return fmt::format("{} {}", fmt::underlying(mode.baud), modbus::format_text(mode.format));
}

Result<std::vector<LineMode>, std::string> parse_modes(std::string_view bauds,
                                                       std::string_view parities,
                                                       std::string_view stop_bits) {
  const auto stops = parse_list(stop_bits, [](auto word) { return number_of(word, 2); });
  if (!stops) {
    return fmt::format("\"{}\" is not a list of stop bits: 1, 2 or 1,2", stop_bits);
  }
  const auto asked =
      parse_list(parities, [](auto word) { return config::value_of(config::kParities, word); });
  if (!asked) {
    return fmt::format("\"{}\" is not a list of parities: even, none, odd, with commas", parities);
  }
  const auto rates = parse_list(bauds, [](auto word) { return number_of(word, kFastestLine); });
  if (!rates) {
    return fmt::format(
        "\"{}\" is not a list of baud rates: 1 to 4000000, with commas, like 9600,19200", bauds);
  }
  std::vector<LineMode> modes;
  for (const auto baud : *rates) {
    for (const auto parity : *asked) {
      for (const auto bits : parity == Parity::none ? *stops : std::vector{1U}) {
        // What is listed twice is asked once.
        if (const LineMode mode{modbus::Baud{baud}, {8, parity, bits}};
            std::ranges::find(modes, mode) == modes.end()) {
          modes.push_back(mode);
        }
      }
    }
  }
  return modes;
}

}  // namespace mbgate::ctl

// SPDX-License-Identifier: Apache-2.0
#include "ctl/serial/serial_port.hpp"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fmt/format.h>
#include <iterator>
#include <system_error>

#include "base/text.hpp"

namespace mbgate::ctl {
namespace {

std::string held_text(const std::string& device) {
  return fmt::format(
      "a gateway or another program holds {}: stop it first (systemctl stop mbgated), or scan "
      "through it with --host and --port",
      device);
}

sys::TtyMode raw_mode(const LineMode& mode) {
  const auto parity = mode.format.parity == modbus::Parity::none   ? sys::TtyParity::none
                      : mode.format.parity == modbus::Parity::even ? sys::TtyParity::even
                                                                   : sys::TtyParity::odd;
  // The CRC of a character with the wrong parity is to fail: a drive that does not look at the
  // parity of the request must not pass for one that has it.
  return {static_cast<std::uint32_t>(mode.baud), 8, parity, mode.format.stop_bits, true};
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

Result<SerialPort, std::string> SerialPort::open(const std::string& device) {
  sys::UniqueFd fd = sys::open_tty(device);
  if (!fd.is_open()) {
    const int error = errno;  // before the names are looked up
    return port_failure(device, error, serial_names());
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
    case EBUSY: return held_text(device);
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

bool is_held(const std::string& device, const std::string& error) {
  return error == held_text(device);
}

std::vector<std::string> serial_names(const std::string& folder) {
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

namespace {

using modbus::Parity;

constexpr std::uint32_t kFastestLine = 4'000'000;  // no UART of Linux has a faster one

std::vector<std::string_view> listed(std::string_view text) {
  std::vector<std::string_view> words;
  while (true) {
    const auto comma = text.find(',');
    words.push_back(text.substr(0, comma));
    if (comma == std::string_view::npos) {
      return words;
    }
    text.remove_prefix(comma + 1);
  }
}

std::optional<std::uint32_t> number_of(std::string_view text, std::uint32_t most) {
  const auto number = integer_in<std::uint32_t>(text);
  return number >= 1U && *number <= most ? number : std::nullopt;
}

std::optional<Parity> parity_of(std::string_view word) {
  for (const auto parity : {Parity::even, Parity::none, Parity::odd}) {
    if (parity_word(parity) == word) {
      return parity;
    }
  }
  return std::nullopt;
}

/// All formats of one parity.
std::vector<modbus::CharacterFormat> formats(Parity parity,
                                             const std::vector<unsigned>& stop_bits) {
  if (parity != Parity::none) {
    return {{8, parity, 1}};
  }
  std::vector<modbus::CharacterFormat> result;
  result.reserve(stop_bits.size());
  for (const auto bits : stop_bits) {
    result.push_back({8, parity, bits});
  }
  return result;
}

}  // namespace

std::string mode_text(const LineMode& mode) {
  return fmt::format("{} {}", fmt::underlying(mode.baud), modbus::format_text(mode.format));
}

std::string_view parity_word(Parity parity) {
  switch (parity) {
    case Parity::none: return "none";
    case Parity::even: return "even";
    case Parity::odd: return "odd";
  }
  return {};
}

Result<std::vector<LineMode>, std::string> parse_modes(std::string_view bauds,
                                                       std::string_view parities,
                                                       std::string_view stop_bits) {
  std::vector<unsigned> stops;
  for (const auto word : listed(stop_bits)) {
    const auto bits = number_of(word, 2);
    if (!bits) {
      return fmt::format("\"{}\" is not a list of stop bits: 1, 2 or 1,2", stop_bits);
    }
    stops.push_back(*bits);
  }
  std::vector<modbus::CharacterFormat> characters;
  for (const auto word : listed(parities)) {
    const auto parity = parity_of(word);
    if (!parity) {
      return fmt::format("\"{}\" is not a list of parities: even, none, odd, with commas",
                         parities);
    }
    std::ranges::copy(formats(*parity, stops), std::back_inserter(characters));
  }
  std::vector<LineMode> modes;
  for (const auto word : listed(bauds)) {
    const auto baud = number_of(word, kFastestLine);
    if (!baud) {
      return fmt::format(
          "\"{}\" is not a list of baud rates: 1 to 4000000, with commas, like 9600,19200", bauds);
    }
    for (const auto& format : characters) {
      // What is listed twice is asked once.
      if (const LineMode mode{modbus::Baud{*baud}, format};
          std::ranges::find(modes, mode) == modes.end()) {
        modes.push_back(mode);
      }
    }
  }
  return modes;
}

}  // namespace mbgate::ctl

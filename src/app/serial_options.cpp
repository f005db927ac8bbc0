// SPDX-License-Identifier: Apache-2.0
#include "app/serial_options.hpp"

namespace mbgate::app {
namespace {

/// A basic string of TOML 1.0.0. A path can hold any byte but 0; what is no UTF-8 is refused when
/// the text is loaded.
std::string toml_string(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string quoted = "\"";
  for (const char byte : text) {
    const auto code = static_cast<unsigned char>(byte);
    if (byte == '"' || byte == '\\') {
      (quoted += '\\') += byte;
    } else if (code < 0x20U || code == 0x7FU) {
      ((quoted += "\\u00") += kDigits[code >> 4U]) += kDigits[code & 0xFU];
    } else {
      quoted += byte;
    }
  }
  return quoted + '"';
}

std::string allow_line(const std::vector<std::string>& allow) {
  if (allow.empty()) {
    return {};
  }
  std::string list;
  for (const auto& network : allow) {
    list += (list.empty() ? "" : ", ") + toml_string(network);
  }
  return "allow = [" + list + "]\n";
}

}  // namespace

Result<ListenAddress, std::string> parse_listen(std::string_view text,
                                                const std::vector<std::string>& allow) {
  const auto listen = ListenAddress::parse(text);
  if (!listen) {
    return "expected an IPv4 or IPv6 address and a port, such as 127.0.0.1:1502 or [::1]:1502, "
           "found \"" +
           std::string(text) + '"';
  }
  if (allow.empty() && !routing::is_loopback(listen->address)) {
    return "other machines reach " + listen->address.to_text() +
           ": add --allow with those who may connect, such as --allow 192.168.10.0/24";
  }
  return *listen;
}

std::string serial_config(const SerialOptions& options) {
  return "# What mbgated --serial serves. mbgate.toml(5) has every key.\n"
         "\n"
         "[[listen]]\n"
         "name = \"clients\"\n"
         "address = " +
         toml_string(options.listen.address.to_text()) +
         "\nport = " + std::to_string(options.listen.port) + "\nbus = \"line\"\n" +
         allow_line(options.allow) +
         "\n"
         "[[bus]]\n"
         "name = \"line\"\n"
         "device = " +
         toml_string(options.device) + "\nbaud = " + std::to_string(options.baud) +
         "\nparity = " + toml_string(options.parity) +
         "\nstop_bits = " + std::to_string(options.stop_bits) + "\n";
}

}  // namespace mbgate::app

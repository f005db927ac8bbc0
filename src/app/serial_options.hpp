// SPDX-License-Identifier: Apache-2.0
// A transparent gateway of one line without a configuration file: the options that describe it, and
// the configuration that they stand for. Its text is loaded as that of a file is, so what is
// checked there is not checked here.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "modbus/result.hpp"
#include "routing/listen_address.hpp"

namespace mbgate::app {

using routing::ListenAddress;

/// The defaults are those of the configuration.
struct SerialOptions {
  std::string device;
  std::int64_t baud = 19200;
  std::string parity = "even";
  std::int64_t stop_bits = 1;
  ListenAddress listen{};            ///< where clients connect
  std::vector<std::string> allow{};  ///< who may connect: addresses or blocks; empty: everyone
};

/// "127.0.0.1:1502" or "[::1]:1502". The error says what is wrong. That is so too where other
/// machines reach the address and `allow` is empty: drives are not opened to a network by chance.
Result<ListenAddress, std::string> parse_listen(std::string_view text,
                                                const std::vector<std::string>& allow);

/// The text of the configuration: one bus, and a transparent listener of it.
std::string serial_config(const SerialOptions& options);

}  // namespace mbgate::app

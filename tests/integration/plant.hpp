// SPDX-License-Identifier: Apache-2.0
// mbgate-sim and mbgated together: buses of simulated drives, a transparent listener for each.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "integration/process.hpp"
#include "integration/tcp_client.hpp"

namespace mbgate::test {

struct PlantOptions {
  bool paced = false;      ///< false: no wire time, no frame gap
  unsigned baud = 115200;  ///< of the gateway's ports, if paced; the drives have 115200
  /// Longer than any machine is busy; shorter only where nobody is to answer.
  std::string response_timeout = "20s";
  std::string listener{};                ///< further keys of every [[listen]]
  std::string bus{};                     ///< further keys of every [[bus]]
  std::string simulated_bus{};           ///< further keys of every simulated [[bus]]
  std::string device{};                  ///< further keys of every simulated [[device]]
  std::string simulator{};               ///< further top-level keys of the simulator
  std::vector<std::string> arguments{};  ///< further arguments of mbgated
};

/// Buses line-0 and line-1 with MOONS' drives at addresses 1 and 2 each; listeners of the same
/// names.
class Plant {
 public:
  explicit Plant(const PlantOptions& options = {});

  [[nodiscard]] std::uint16_t port(int bus) {
    return gateway.port_of("line-" + std::to_string(bus));
  }

  TemporaryFolder folder;
  Process simulator;
  Process gateway;
};

/// A request in MBAP: transaction, unit, PDU in hexadecimal.
ByteString request(unsigned transaction, unsigned unit, std::string_view pdu);

}  // namespace mbgate::test

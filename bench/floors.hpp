// SPDX-License-Identifier: Apache-2.0
// What a gateway is measured against: programs that do as little as can be done.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "plant.hpp"

namespace mbgate::bench {

/// A bare Modbus master, without TCP: on each line it asks one device after the other, t3.5 after
/// the last byte of the response to the one before. Until it is killed.
void run_master(const Plant& plant, const std::vector<std::string>& paths);

/// A relay between the clients of one listening socket and one line that looks at nothing but
/// lengths: exchanges the MBAP header for address and CRC and back, first come, first served.
/// Requests must come in one piece, one at a time from each client. Until it is killed.
void run_relay(const Plant& plant, const std::string& path, int listening);

}  // namespace mbgate::bench

// SPDX-License-Identifier: Apache-2.0
#include "modbus/lrc.hpp"

#include <numeric>

namespace mbgate::modbus {

std::uint8_t lrc(Bytes bytes) {
  const unsigned sum = std::accumulate(bytes.begin(), bytes.end(), 0U);
  return static_cast<std::uint8_t>(0U - sum);
}

}  // namespace mbgate::modbus

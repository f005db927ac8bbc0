// SPDX-License-Identifier: Apache-2.0
// Ranges of registers of MOONS' drives. The manual prints none in its tables; what counts here is
// that a rate of 0 is none.
#pragma once

#include "sim/drives/register_bank.hpp"

namespace mbgate::sim {

inline constexpr Limits kRate{1, 32000};
inline constexpr Limits kProtocol{1, 511};

}  // namespace mbgate::sim

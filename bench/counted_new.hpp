// SPDX-License-Identifier: Apache-2.0
// Linked into a program, it counts how often `new` asks for memory.
#pragma once

#include <cstdint>

namespace mbgate::bench {

std::uint64_t allocations();

}  // namespace mbgate::bench

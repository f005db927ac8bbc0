// SPDX-License-Identifier: Apache-2.0
// Whether anybody new may be let in. Where an allocation is refused (a limit of the process, or
// overcommitment off), the machine cannot go on with half of an input, and the process ends. So
// clients are refused while there is still enough for those who are served.
//
// It does not help where the kernel ends the process instead of refusing (MemoryMax= of
// systemd.resource-control).
#pragma once

#include <cstddef>

namespace mbgate::io {

/// More than the full queues of several buses take, and what is asked and told meanwhile.
inline constexpr std::size_t kMemoryLeft = 8'388'608;

/// Could so much be had now? Any thread may ask. It takes no page of memory.
bool is_memory_left();

}  // namespace mbgate::io

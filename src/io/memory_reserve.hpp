// SPDX-License-Identifier: Apache-2.0
// Memory that is kept for what was begun. Where an allocation is refused (a limit of the process,
// or overcommitment off), the reserve is given up for it, and until it can be had again nobody new
// is let in. So clients are refused before the machine, which cannot go on with half of an input,
// is short of anything. If it still is, the process ends and is started again.
//
// It holds addresses, and hardly a page of memory until then. It does not help where the kernel
// ends the process instead of refusing (MemoryMax= of systemd.resource-control).
#pragma once

#include <cstddef>

namespace mbgate::io {

/// More than the full queues of several buses take, and what is asked and told meanwhile.
inline constexpr std::size_t kMemoryReserve = 8'388'608;

/// From now on there is one. Of the whole process; may be called again.
void keep_memory_reserve();

/// False while more of the reserve is in use than a little: too little memory for new clients. Any
/// thread may ask.
bool is_memory_left();

}  // namespace mbgate::io

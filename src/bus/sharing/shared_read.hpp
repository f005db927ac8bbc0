// SPDX-License-Identifier: Apache-2.0
// Identical reads that wait at the same time are transmitted once (`coalesce`). A read is not
// shared across a write to the device that waits between, nor ahead of earlier requests of its own
// client. So no client gets data older than its request or its own write.
#pragma once

#include "bus/queue/bus_queue.hpp"
#include "bus/transmission/transmission.hpp"

namespace mbgate::bus {

/// Removes from the queue the reads that can be answered by the transmission, whose turn it is, and
/// makes them its followers.
void gather_followers(BusQueue& queue, Transmission& transmission);

}  // namespace mbgate::bus

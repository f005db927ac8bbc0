// SPDX-License-Identifier: Apache-2.0
// Reads that wait at the same time and are transmitted once: identical ones and, with `merge`,
// adjacent and overlapping ones. A read is not shared across a write to the device that waits
// between, nor ahead of earlier requests of its own client. So no client gets data older than its
// request or its own write.
#pragma once

#include "bus/queue/bus_queue.hpp"
#include "bus/settings.hpp"
#include "bus/transmission/transmission.hpp"
#include "drive/device.hpp"

namespace mbgate::bus {

/// What may be shared on a bus.
struct Sharing {
  bool coalesce;
  bool merge;
};

/// Removes from the queue the reads that can be answered by the transmission, whose turn it is, and
/// makes them its followers. `merged` is then the longer read, if there is one.
void gather_followers(BusQueue& queue, Transmission& transmission, const drive::Device& device,
                      Sharing sharing);

/// The part of a read's normal response (01 to 04) that answers a shorter read within it.
modbus::Pdu part_of(const modbus::Pdu& response, const modbus::TableRange& whole,
                    const modbus::TableRange& part);

}  // namespace mbgate::bus

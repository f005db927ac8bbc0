// SPDX-License-Identifier: Apache-2.0
#include "bus/sharing/read_cache.hpp"

#include <algorithm>

namespace mbgate::bus {

const modbus::Pdu* ReadCache::find(const modbus::Request& request, Instant oldest) const {
  const auto found = std::ranges::find(reads_, request.pdu(), &Read::request);
  return found == reads_.end() || found->asked_at < oldest ? nullptr : &found->response;
}

void ReadCache::put(const modbus::Request& request, const modbus::Pdu& response, Instant asked_at,
                    std::uint64_t writes_ended) {
  if (writes_ended < accepted_) {
    return;
  }
  const auto found = std::ranges::find(reads_, request.pdu(), &Read::request);
  if (found != reads_.end()) {
    *found = {request.pdu(), response, asked_at};
  } else if (reads_.size() < kMostCachedReads) {
    reads_.push_back({request.pdu(), response, asked_at});
  } else {
    *std::ranges::min_element(reads_, {}, &Read::asked_at) = {request.pdu(), response, asked_at};
  }
}

void ReadCache::begin_write() {
  ++accepted_;
  clear();
}

void ReadCache::end_write() { ++ended_; }

}  // namespace mbgate::bus

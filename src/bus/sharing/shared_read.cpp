// SPDX-License-Identifier: Apache-2.0
#include "bus/sharing/shared_read.hpp"

#include <algorithm>

namespace mbgate::bus {
namespace {

// On a Modbus TCP bus one device may be asked by several units. Should these be drives after all,
// each answers for itself.
bool is_identical(const Transaction& a, const Transaction& b) {
  return a.address == b.address && a.unit == b.unit && a.request.pdu() == b.request.pdu();
}

bool crosses_write(const BusQueue& queue, const Job& one, const Job& other) {
  const auto [first, last] = std::minmax(one.sequence, other.sequence);
  return queue.write_waits_between(one.address(), first, last);
}

}  // namespace

void gather_followers(BusQueue& queue, Transmission& transmission) {
  const Job& leader = *transmission.leader;
  if (!leader.is_single_read()) {
    return;
  }
  boost::container::small_vector<Job*, 8> joined;  // the queue does not change while it is visited
  queue.visit_fronts(leader.address(), [&](Job& job) {
    const bool joins = job.is_single_read() && !crosses_write(queue, job, leader) &&
                       is_identical(job.transaction(), leader.transaction());
    if (joins) {
      joined.push_back(&job);
    }
    return joins;
  });
  for (Job* job : joined) {
    queue.remove(*job);
    transmission.followers.push_back(job);
  }
}

}  // namespace mbgate::bus

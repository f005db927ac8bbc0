// SPDX-License-Identifier: Apache-2.0
#include "soak/adapter.hpp"

#include <algorithm>
#include <utility>

namespace mbgate::soak {

using namespace std::chrono_literals;

Instant Adapter::arrival() {
  const Instant now = schedule_.now();
  Instant at = now;
  switch (kind_) {
    case AdapterKind::uart: break;
    case AdapterKind::ticking: {
      const Duration since = (now - phase_).time_since_epoch() % kTick;
      at = now + (kTick - since);
      break;
    }
    case AdapterKind::late: at = now + random_.duration(0us, kAdapterHolds); break;
  }
  last_ = std::max(last_, at);
  return last_;
}

void Adapter::take(Heard heard, Instant arrival) {
  if (arrival <= schedule_.now()) {
    hand_over_(heard);
    return;
  }
  schedule_.at(arrival, [this, epoch = epoch_, it = std::move(heard)] {
    if (epoch == epoch_) {
      hand_over_(it);
    }
  });
}

void Adapter::reset() {
  ++epoch_;
  last_ = Instant::min();
}

}  // namespace mbgate::soak

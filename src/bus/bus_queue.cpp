// SPDX-License-Identifier: Apache-2.0
#include "bus/bus_queue.hpp"

namespace mbgate::bus {

bool BusQueue::push(Job& job) {
  if (size() >= limit_) {
    return false;
  }
  const auto index = static_cast<std::size_t>(job.source);
  while (sources_.size() <= index) {
    sources_.emplace_back();
  }
  Source& source = sources_[index];
  source.waiting.push_back(job);
  if (!source.round_hook.is_linked()) {
    round_.push_back(source);
  }
  by_deadline_.insert(job);
  return true;
}

void BusQueue::take(Job& job) {
  Source& source = source_of(job);
  remove(job);
  if (source.round_hook.is_linked()) {
    round_.splice(round_.end(), round_, Round::s_iterator_to(source));
  }
}

void BusQueue::remove(Job& job) {
  Source& source = source_of(job);
  source.waiting.erase(JobList::s_iterator_to(job));
  if (source.waiting.empty()) {
    round_.erase(Round::s_iterator_to(source));
  }
  by_deadline_.erase(DeadlineSet::s_iterator_to(job));
}

Job* BusQueue::first_to_expire() { return by_deadline_.empty() ? nullptr : &*by_deadline_.begin(); }

std::optional<Instant> BusQueue::first_deadline() const {
  return by_deadline_.empty() ? std::nullopt : std::optional(by_deadline_.begin()->deadline);
}

}  // namespace mbgate::bus

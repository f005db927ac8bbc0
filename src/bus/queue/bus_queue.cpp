// SPDX-License-Identifier: Apache-2.0
#include "bus/queue/bus_queue.hpp"

#include <algorithm>
#include <limits>

namespace mbgate::bus {

BusQueue::Source& BusQueue::source_of(const Job& job) {
  const auto index = static_cast<std::size_t>(job.source);
  while (sources_.size() <= index) {
    sources_.push_back(std::make_unique<Source>());
  }
  return *sources_[index];
}

bool BusQueue::push(Job& job) {
  if (by_deadline_.size() >= limit_) {
    return false;
  }
  Source& source = source_of(job);
  source.waiting.push_back(job);
  source.weight = job.weight;
  if (!source.round_hook.is_linked()) {
    source.turns = source.weight;
    round_.push_back(source);
  }
  by_deadline_.insert(job);
  writes_ += is_write(job.job_class) ? 1U : 0U;
  return true;
}

Job* BusQueue::read_to_evict() {
  const auto most = std::ranges::max_element(
      round_, {}, [](const Source& source) { return source.waiting.size(); });
  if (most == round_.end()) {
    return nullptr;
  }
  const auto newest = std::find_if(most->waiting.rbegin(), most->waiting.rend(),
                                   [](const Job& job) { return job.job_class == JobClass::read; });
  return newest == most->waiting.rend() ? nullptr : &*newest;
}

std::pair<std::uint64_t, std::uint64_t> BusQueue::writes_around(std::uint8_t address,
                                                                std::uint64_t sequence) {
  std::uint64_t before = 0;
  std::uint64_t behind = std::numeric_limits<std::uint64_t>::max();
  if (writes_ > 0) {
    visit_all([&](const Job& job) {
      if (is_write(job.job_class) && (job.is_broadcast() || job.address() == address)) {
        before = job.sequence < sequence ? std::max(before, job.sequence) : before;
        behind = job.sequence > sequence ? std::min(behind, job.sequence) : behind;
      }
    });
  }
  return {before, behind};
}

void BusQueue::take(Job& job) {
  Source& source = source_of(job);
  remove(job);
  if (!source.round_hook.is_linked()) {
    return;
  }
  if (--source.turns == 0) {
    source.turns = source.weight;
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
  writes_ -= is_write(job.job_class) ? 1U : 0U;
}

Job* BusQueue::first_to_expire() { return by_deadline_.empty() ? nullptr : &*by_deadline_.begin(); }

std::optional<BusQueue::Most> BusQueue::most_waiting(const Addresses& held_back) const {
  Most most;
  std::size_t all = 0;
  for (const Source& source : round_) {
    const auto counts = [&](const Job& job) { return !held_back[job.address()]; };
    const auto first = std::ranges::find_if(source.waiting, counts);
    const auto requests =
        static_cast<std::size_t>(std::count_if(first, source.waiting.end(), counts));
    if (requests > most.requests) {
      most = {first->source, requests, 0, first->accepted_at};
    }
    all += requests;
  }
  most.of = all;
  return all == 0 ? std::nullopt : std::optional(most);
}

Duration BusQueue::longest_wait(Instant now) const {
  const auto first = std::ranges::min_element(by_deadline_, {}, &Job::accepted_at);
  return first == by_deadline_.end() ? Duration{0}
                                     : std::max(now - first->accepted_at, Duration{0});
}

std::optional<Instant> BusQueue::first_deadline() const {
  return by_deadline_.empty() ? std::nullopt : std::optional(by_deadline_.begin()->deadline);
}

}  // namespace mbgate::bus

// SPDX-License-Identifier: Apache-2.0
#include "gateway/clients/due_answers.hpp"

#include "base/assert.hpp"

namespace mbgate::gateway {

AnswerId DueAnswers::open() {
  if (!ordered_) {
    ++open_;
    return AnswerId{0};
  }
  held_.emplace_back();
  return AnswerId{first_held_ + held_.size() - 1};
}

DueAnswers::Ready DueAnswers::close(AnswerId id, const std::optional<modbus::MbapBytes>& adu) {
  Ready ready;
  if (!ordered_) {
    MBGATE_ASSERT(open_ > 0, "one answer for each request");
    --open_;
    if (adu) {
      ready.push_back(*adu);
    }
  } else {
    const auto place = static_cast<std::size_t>(static_cast<std::uint64_t>(id) - first_held_);
    MBGATE_ASSERT(place < held_.size() && !held_[place].done, "one answer for each request");
    Held& held = held_[place];
    held.done = true;
    held.adu = adu;
    while (!held_.empty() && held_.front().done) {
      if (held_.front().adu) {
        ready.push_back(*held_.front().adu);
      }
      held_.pop_front();
      ++first_held_;
    }
  }
  unsent_ += ready.size();
  return ready;
}

void DueAnswers::confirm_sent() {
  if (unsent_ > 0) {
    --unsent_;
  }
}

}  // namespace mbgate::gateway

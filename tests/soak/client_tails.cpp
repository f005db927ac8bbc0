// SPDX-License-Identifier: Apache-2.0
// A client whose pieces always end within a request: the rest of it comes with the beginning of the
// next one, or after a while. Each request is whole soon, but hardly ever is nothing left over.
#include <algorithm>

#include "soak/client.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr std::uint64_t kTailsChance = 0x5441494C53ULL;  // apart from the plant's
constexpr unsigned kSome = 60;
constexpr Duration kLongestTail = 200ms;  // well within the shortest frame timeout
constexpr Duration kMostPause = 60ms;
constexpr unsigned kLeastOutstanding = 4;

}  // namespace

// Not where the process is stopped: it would come too late to the rest.
void Client::become_straddler() {
  const auto place = static_cast<std::uint64_t>(
      std::ranges::find(tools_.all, this, [](const Client& it) { return &it; }) -
      tools_.all.begin());
  const bool may_be = !tools_.plan.silence && !tools_.plan.driver.stops && manners_.hangs == 0 &&
                      manners_.loses_framing == 0 && !manners_.never_asks &&
                      !manners_.waits_at_start;
  straddles_ = may_be && Random(tools_.plan.seed * kTailsChance + place).chance(kSome);
  if (straddles_) {
    tools_.report.fault("straddler");
    manners_.outstanding = std::max(manners_.outstanding, kLeastOutstanding);
    manners_.pause = std::min<Duration>(manners_.pause, kMostPause);
    manners_.least_pause = std::min(manners_.least_pause, manners_.pause);
    manners_.rests = 0;
  }
}

void Client::keep_tail(std::size_t request) {
  push(unwritten_.size() - 1 - tools_.random.below(request - 1));
  tools_.schedule.after(tools_.random.duration(kLongestTail / 2, kLongestTail),
                        [this, life = life_, made = made_] {
                          const bool is_last = made == made_ || !keeps_tails();
                          if (life == life_ && connected_ && !vanished_ && is_last) {
                            push(unwritten_.size());
                          }
                        });
}

}  // namespace mbgate::soak

// SPDX-License-Identifier: Apache-2.0
#include "samples.hpp"

#include <algorithm>

namespace mbgate::bench {

Spread Samples::spread() const {
  if (values_.empty()) {
    return {};
  }
  auto sorted = values_;
  std::ranges::sort(sorted);
  const auto at = [&](std::size_t permille) {
    const std::size_t rank = (sorted.size() * permille + 999) / 1000;
    return sorted[std::max<std::size_t>(rank, 1) - 1];
  };
  return {at(500), at(900), at(990), at(999), sorted.back()};
}

}  // namespace mbgate::bench

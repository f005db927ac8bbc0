// SPDX-License-Identifier: Apache-2.0
// Apart from what it counts, so that no compiler sees both `new` and the free() behind `delete`.
#include "counted_new.hpp"

#include <cstdlib>
#include <new>

namespace {

std::uint64_t count = 0;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

}  // namespace

namespace mbgate::bench {

std::uint64_t allocations() { return count; }

}  // namespace mbgate::bench

// NOLINTBEGIN(cppcoreguidelines-no-malloc): it is what malloc is counted for
void* operator new(std::size_t size) {
  ++count;
  if (void* place = std::malloc(size)) {
    return place;
  }
  throw std::bad_alloc();
}
void operator delete(void* place) noexcept { std::free(place); }
void operator delete(void* place, std::size_t /*size*/) noexcept { std::free(place); }
// NOLINTEND(cppcoreguidelines-no-malloc)

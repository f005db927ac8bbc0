// SPDX-License-Identifier: Apache-2.0
#include "io/memory_reserve.hpp"

#include <atomic>
#include <new>

namespace mbgate::io {
namespace {

/// Nothing: there is none, or it is in use. From the heap: what is free there counts too, where the
/// process may not grow.
std::atomic<void*> reserve{nullptr};
std::atomic<bool> is_kept{false};

// The allocation that was refused is tried again when this returns ([new.handler]).
void handle_refusal() {
  void* const kept = reserve.exchange(nullptr);
  if (kept == nullptr) {
    throw std::bad_alloc();
  }
  ::operator delete(kept);
}

// If it is refused the handler is asked, which has nothing to give up then. Half of it will do: the
// memory that became free again may lie in pieces.
bool take_back() {
  void* taken = ::operator new(kMemoryReserve, std::nothrow);
  if (taken == nullptr) {
    taken = ::operator new(kMemoryReserve / 2, std::nothrow);
  }
  void* none = nullptr;
  if (taken != nullptr && !reserve.compare_exchange_strong(none, taken)) {
    ::operator delete(taken);  // another thread was first
  }
  return taken != nullptr;
}

}  // namespace

void keep_memory_reserve() {
  if (!is_kept.exchange(true)) {
    take_back();
    std::set_new_handler(handle_refusal);
  }
}

bool is_memory_left() { return !is_kept || reserve != nullptr || take_back(); }

}  // namespace mbgate::io

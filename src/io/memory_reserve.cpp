// SPDX-License-Identifier: Apache-2.0
#include "io/memory_reserve.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <new>

namespace mbgate::io {
namespace {

/// In pieces, because the memory that becomes free again may lie in pieces too.
constexpr std::size_t kPiece = 65'536;
constexpr std::size_t kPieces = kMemoryReserve / kPiece;
/// So many may be missing before nobody new is let in.
constexpr std::size_t kMayBeMissing = kPieces / 16;

/// Nothing: it is in use. From the heap: what is free there counts too, where the process may not
/// grow.
std::array<std::atomic<void*>, kPieces> pieces{};
std::atomic<bool> is_kept{false};
/// The handler has nothing to give for a piece.
thread_local bool is_taking = false;

// The allocation that was refused is tried again when this returns ([new.handler]).
void handle_refusal() {
  for (auto& piece : pieces) {
    void* const kept = is_taking ? nullptr : piece.exchange(nullptr);
    if (kept != nullptr) {
      ::operator delete(kept);
      return;
    }
  }
  throw std::bad_alloc();
}

void take_back() {
  is_taking = true;
  for (auto& piece : pieces) {
    void* const taken = piece == nullptr ? ::operator new(kPiece, std::nothrow) : nullptr;
    void* none = nullptr;
    if (taken != nullptr && !piece.compare_exchange_strong(none, taken)) {
      ::operator delete(taken);  // another thread was first
    }
  }
  is_taking = false;
}

}  // namespace

void keep_memory_reserve() {
  if (!is_kept.exchange(true)) {
    take_back();
    std::set_new_handler(handle_refusal);
  }
}

bool is_memory_left() {
  if (!is_kept) {
    return true;
  }
  take_back();
  return std::ranges::count(pieces, nullptr, [](const auto& piece) { return piece.load(); }) <=
         static_cast<std::ptrdiff_t>(kMayBeMissing);
}

}  // namespace mbgate::io

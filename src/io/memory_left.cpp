// SPDX-License-Identifier: Apache-2.0
#include "io/memory_left.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <new>

namespace mbgate::io {
namespace {

/// What is free on the heap may lie in pieces.
constexpr std::size_t kPiece = 65'536;
constexpr std::size_t kPieces = kMemoryLeft / kPiece;

// Not from the heap, which would keep it.
bool can_grow() {
  void* const mapped =
      ::mmap(nullptr, kMemoryLeft, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  return mapped != MAP_FAILED && ::munmap(mapped, kMemoryLeft) == 0;
}

bool has_free_heap() {
  std::array<void*, kPieces> pieces{};
  std::ranges::generate(pieces, [] { return ::operator new(kPiece, std::nothrow); });
  const bool has_all = std::ranges::find(pieces, nullptr) == pieces.end();
  std::ranges::for_each(pieces, [](void* piece) { ::operator delete(piece); });
  return has_all;
}

}  // namespace

bool is_memory_left() { return can_grow() || has_free_heap(); }

}  // namespace mbgate::io

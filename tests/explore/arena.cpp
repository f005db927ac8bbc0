// SPDX-License-Identifier: Apache-2.0
#include "explore/arena.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <new>
#include <utility>

namespace mbgate::explore {
namespace {

constexpr std::size_t kUnit = alignof(std::max_align_t);
constexpr std::size_t kUnits = std::size_t{1} << 20U;

// A block has as many bytes as a power of two, behind this.
struct alignas(kUnit) Block {
  std::size_t power;
  Block* next_free;  // of the same size
};

// It is copied with the rest.
struct Arena {
  std::size_t used = 0;  // of the bytes behind it
  std::array<Block*, 32> free{};
  alignas(kUnit) std::array<std::byte, kUnits * kUnit> bytes;
};

Arena arena;
bool is_in_use = false;

void* allocate(std::size_t size) {
  const auto power = static_cast<std::size_t>(std::bit_width(std::max(size, kUnit) - 1));
  Block* block = std::exchange(arena.free.at(power), nullptr);
  if (block != nullptr) {
    arena.free[power] = block->next_free;
    return block + 1;
  }
  const std::size_t end = arena.used + sizeof(Block) + (std::size_t{1} << power);
  if (end > arena.bytes.size()) {
    std::abort();
  }
  block = new (&arena.bytes[std::exchange(arena.used, end)]) Block{power, nullptr};
  return block + 1;
}

void release(void* pointer) {
  Block* block = static_cast<Block*>(pointer) - 1;
  block->next_free = std::exchange(arena.free.at(block->power), block);
}

bool is_inside(const void* pointer) {
  return std::greater_equal<>{}(pointer, static_cast<const void*>(&arena)) &&
         std::less<>{}(pointer, static_cast<const void*>(&arena + 1));
}

}  // namespace

Allocating::Allocating(Where where)
    : was_in_arena_(std::exchange(is_in_use, where == Where::in_arena)) {}

Allocating::~Allocating() { is_in_use = was_in_arena_; }

void copy_arena(std::vector<std::byte>& copy) {
  const auto* begin = reinterpret_cast<const std::byte*>(&arena);
  copy.assign(begin, begin + offsetof(Arena, bytes) + arena.used);
}

void put_back(const std::vector<std::byte>& copy) {
  std::memcpy(static_cast<void*>(&arena), copy.data(), copy.size());
}

}  // namespace mbgate::explore

// NOLINTBEGIN(cppcoreguidelines-no-malloc): only programs that explore are linked with these
void* operator new(std::size_t size) {
  using namespace mbgate::explore;
  void* const found = is_in_use ? allocate(size) : std::malloc(std::max<std::size_t>(size, 1));
  return found != nullptr ? found : throw std::bad_alloc();
}

void operator delete(void* pointer) noexcept {
  using namespace mbgate::explore;
  is_inside(pointer) ? release(pointer) : std::free(pointer);
}

void operator delete(void* pointer, std::size_t /*size*/) noexcept { operator delete(pointer); }
// NOLINTEND(cppcoreguidelines-no-malloc)

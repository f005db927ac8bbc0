// SPDX-License-Identifier: Apache-2.0
// Memory whose content can be copied and put back. A gateway cannot be copied, but what lies here
// can: all that was allocated while an `Allocating` said so. There is one arena, of one thread.
#pragma once

#include <cstddef>
#include <vector>

namespace mbgate::explore {

/// For as long as it lives, everything is allocated in the arena, or nothing is.
class Allocating {
 public:
  enum class Where : bool { elsewhere, in_arena };

  explicit Allocating(Where where);
  ~Allocating();
  Allocating(const Allocating&) = delete;
  Allocating& operator=(const Allocating&) = delete;

 private:
  bool was_in_arena_;
};

/// Copies all that is in the arena.
void copy_arena(std::vector<std::byte>& copy);
/// All that is in the arena becomes what it was when it was copied, at the same addresses.
void put_back(const std::vector<std::byte>& copy);

}  // namespace mbgate::explore

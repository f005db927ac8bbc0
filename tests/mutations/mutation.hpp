// SPDX-License-Identifier: Apache-2.0
// What asks in a copy of the product whether one of its mutants is switched on (mutate.py). The
// environment is read once; which were asked for is written at the end.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <type_traits>

namespace mbgate::mutation {

inline constexpr int kMost = 100000;
inline bool active[kMost];
inline bool reached[kMost];

inline void write_reached() {
  std::FILE* file = std::fopen(std::getenv("MBGATE_MUTANTS_REACHED"), "a");
  for (int number = 0; file != nullptr && number < kMost; ++number) {
    if (reached[number]) {
      std::fprintf(file, "%d\n", number);
    }
  }
  if (file != nullptr) {
    std::fclose(file);
  }
}

/// Before anything else that is constructed; every source has it, the first one does it.
[[gnu::constructor(101)]] inline void read_environment() {
  static constinit bool is_read = false;
  if (is_read) {
    return;
  }
  is_read = true;
  for (char* at = std::getenv("MBGATE_MUTANT"); at != nullptr && *at != '\0';) {
    active[std::strtol(at, &at, 10) % kMost] = true;
    at += *at == ',' ? 1 : 0;
  }
  if (std::getenv("MBGATE_MUTANTS_REACHED") != nullptr) {
    std::atexit(write_reached);
  }
}

[[gnu::noinline]] inline bool on(int number) {
  reached[number] = true;
  return active[number];
}

/// For functions that are constant. Elsewhere it would be taken for a constant: `const int a = 3`.
constexpr bool is(int number) { return !std::is_constant_evaluated() && on(number); }

}  // namespace mbgate::mutation

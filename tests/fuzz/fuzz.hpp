// SPDX-License-Identifier: Apache-2.0
// What the fuzz targets share: a script of bytes that is read piece by piece, and a check that ends
// the process, so that the fuzzer keeps the input.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "modbus/bytes.hpp"

/// The head of a target's function. A fuzzer has one, by libFuzzer's name; fuzz_tests has them all,
/// each by its own.
#ifdef MBGATE_ALL_FUZZ_TARGETS
#define MBGATE_FUZZ_TARGET(name) \
  extern "C" int fuzz_##name(const std::uint8_t* data, std::size_t size)
#else
#define MBGATE_FUZZ_TARGET(name) \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
#endif

namespace mbgate::fuzz {

/// The input as a script; behind its end everything is 0 and empty.
class Script {
 public:
  Script(const std::uint8_t* data, std::size_t size) : rest_(data, size) {}

  [[nodiscard]] bool empty() const { return rest_.empty(); }
  std::uint8_t byte() {
    const modbus::Bytes one = take(1);
    return one.empty() ? std::uint8_t{0} : one[0];
  }
  std::uint16_t word() {
    const auto high = static_cast<unsigned>(byte()) << 8U;
    return static_cast<std::uint16_t>(high | byte());
  }
  /// 0 to `below - 1`.
  std::uint16_t number(std::uint16_t below) { return static_cast<std::uint16_t>(word() % below); }
  bool flag() { return (byte() & 1U) != 0; }
  /// At most `size` bytes.
  modbus::Bytes take(std::size_t size) {
    const modbus::Bytes taken = rest_.first(std::min(size, rest_.size()));
    rest_ = rest_.subspan(taken.size());
    return taken;
  }
  /// As many as the next byte says.
  modbus::Bytes piece() { return take(byte()); }
  modbus::Bytes rest() { return take(rest_.size()); }

 private:
  modbus::Bytes rest_;
};

/// Ends the process with the text if the fact is none.
inline void require(bool fact, const char* text) {
  if (!fact) {
    std::fprintf(stderr, "does not hold: %s\n", text);
    std::abort();
  }
}

}  // namespace mbgate::fuzz

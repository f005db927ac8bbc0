// SPDX-License-Identifier: Apache-2.0
// The bytes that an RTU line has brought one after the other, whoever they come from. By chance one
// in 65,536 completes a good CRC with those before it; and zeros behind a good frame leave its CRC
// good. And what is heard within a frame that pauses may end in that frame's own first byte: with
// its rest it is the same frame again. Nobody could tell that from an answer, so such a byte is
// another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "soak/specification.hpp"

namespace mbgate::soak {

/// The size of a shorter frame that it begins with by chance.
std::optional<std::size_t> frame_within(spec::Bytes frame);

class Overheard {
 public:
  /// A byte of a frame, as it was sent.
  void add(std::uint8_t byte);
  /// The same; `size`: of the frame that ends in it, or 0 if there is none that was heard without
  /// anything in between. Returns another byte, by which that frame is damaged, if one from
  /// `address` would end in it that nobody has sent.
  std::uint8_t add(std::uint8_t byte, std::uint8_t address, std::size_t size);
  /// A byte that belongs to none, or to one that was hit. Returns the one that is heard in its
  /// place: no frame from `address` ends in it.
  std::uint8_t add_stray(std::uint8_t byte, std::uint8_t address);
  /// What comes from now on cannot be taken for more of what came.
  void forget() { bytes_.clear(); }
  /// The bytes that were heard in all.
  [[nodiscard]] std::uint64_t count() const { return count_; }

 private:
  [[nodiscard]] bool ends_a_frame(std::uint8_t address, std::size_t but_for = 0) const;

  std::vector<std::uint8_t> bytes_;
  std::uint64_t count_ = 0;
};

}  // namespace mbgate::soak

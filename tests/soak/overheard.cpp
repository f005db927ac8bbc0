// SPDX-License-Identifier: Apache-2.0
#include "soak/overheard.hpp"

namespace mbgate::soak {

std::optional<std::size_t> frame_within(spec::Bytes frame) {
  constexpr std::size_t kLeast = 4;
  for (std::size_t size = kLeast; size < frame.size(); ++size) {
    if (spec::ends_in_its_crc(frame.first(size))) {
      return size;
    }
  }
  return std::nullopt;
}

void Overheard::add(std::uint8_t byte) {
  ++count_;
  if (bytes_.size() == spec::kRtuFrame) {
    bytes_.erase(bytes_.begin());
  }
  bytes_.push_back(byte);
}

std::uint8_t Overheard::add(std::uint8_t byte, std::uint8_t address, std::size_t size) {
  add(byte);
  if (ends_a_frame(address, size)) {
    bytes_.pop_back();
    return add_stray(static_cast<std::uint8_t>(byte + 1U), address);
  }
  return byte;
}

std::uint8_t Overheard::add_stray(std::uint8_t byte, std::uint8_t address) {
  add(byte);
  while (ends_a_frame(address)) {
    ++bytes_.back();
  }
  return bytes_.back();
}

bool Overheard::ends_a_frame(std::uint8_t address, std::size_t but_for) const {
  for (std::size_t at = 0; at < bytes_.size(); ++at) {
    if (bytes_[at] == address && bytes_.size() - at != but_for &&
        spec::ends_in_its_crc(spec::Bytes(bytes_).subspan(at))) {
      return true;
    }
  }
  return false;
}

}  // namespace mbgate::soak

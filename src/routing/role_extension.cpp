// SPDX-License-Identifier: Apache-2.0
#include "routing/role_extension.hpp"

#include <optional>
#include <string>

namespace mbgate::routing {
namespace {

using modbus::Bytes;

constexpr std::uint8_t kUtf8String = 0x0C;
/// A length from here on stands in bytes of its own (X.690, 8.1.3).
constexpr std::uint8_t kLongLength = 0x80;

/// The contents of a UTF8String that is all of these bytes. DER has one form for each length; up to
/// 255 it is one byte, or 0x81 and one byte of 128 or more.
std::optional<Bytes> contents_of(Bytes der) {
  if (der.size() < 2 || der[0] != kUtf8String) {
    return std::nullopt;
  }
  std::size_t length = der[1];
  std::size_t head = 2;
  if (der[1] == kLongLength + 1 && der.size() > 2 && der[2] >= kLongLength) {
    length = der[2];
    head = 3;
  } else if (der[1] >= kLongLength) {
    return std::nullopt;
  }
  if (length > kLongestRole || der.size() != head + length) {
    return std::nullopt;
  }
  return der.subspan(head);
}

/// How many bytes follow the first one, and the smallest character that needs so many.
struct Utf8Head {
  std::size_t more;
  std::uint32_t bits;
  std::uint32_t smallest;
};

std::optional<Utf8Head> utf8_head(std::uint8_t first) {
  if (first < 0x80) {
    return Utf8Head{0, first, 0};
  }
  if ((first & 0xE0U) == 0xC0U) {
    return Utf8Head{1, first & 0x1FU, 0x80};
  }
  if ((first & 0xF0U) == 0xE0U) {
    return Utf8Head{2, first & 0x0FU, 0x800};
  }
  if ((first & 0xF8U) == 0xF0U) {
    return Utf8Head{3, first & 0x07U, 0x10000};
  }
  return std::nullopt;
}

/// RFC 3629: no character in more bytes than it needs, no surrogates, none beyond U+10FFFF.
bool is_utf8(Bytes text) {
  for (std::size_t at = 0; at < text.size();) {
    const auto head = utf8_head(text[at]);
    if (!head || text.size() - at <= head->more) {
      return false;
    }
    std::uint32_t character = head->bits;
    for (std::size_t i = 1; i <= head->more; ++i) {
      if ((text[at + i] & 0xC0U) != 0x80U) {
        return false;
      }
      character = (character << 6U) | (text[at + i] & 0x3FU);
    }
    const bool is_surrogate = character >= 0xD800 && character <= 0xDFFF;
    if (character < head->smallest || is_surrogate || character > 0x10FFFF) {
      return false;
    }
    at += head->more + 1;
  }
  return true;
}

}  // namespace

ClientRole role_of(std::span<const Bytes> values) {
  if (values.empty()) {
    return {ClientRole::Kind::named, {}};
  }
  const auto role = values.size() == 1 ? contents_of(values[0]) : std::nullopt;
  if (!role || role->empty() || !is_utf8(*role)) {
    return {ClientRole::Kind::unreadable, {}};
  }
  return {ClientRole::Kind::named, std::string(role->begin(), role->end())};
}

}  // namespace mbgate::routing

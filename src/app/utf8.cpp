// SPDX-License-Identifier: Apache-2.0
#include "app/utf8.hpp"

#include <cstddef>

#include "base/utf8.hpp"

namespace mbgate::app {

std::string valid_utf8(std::string_view text) {
  std::string valid;
  while (!text.empty()) {
    const std::size_t size = first_character(text).size;
    valid += size == 0 ? "\xEF\xBF\xBD" : text.substr(0, size);
    text.remove_prefix(size == 0 ? 1 : size);
  }
  return valid;
}

}  // namespace mbgate::app

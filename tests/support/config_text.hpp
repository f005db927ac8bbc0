// SPDX-License-Identifier: Apache-2.0
// Settings from a text, without a file.
#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "config/load.hpp"

namespace mbgate::test {

/// `name`: the file's name in the diagnostics.
inline config::Loaded load_settings_text(std::string name, std::string_view text,
                                         config::ProfileSearch search = {}) {
  return config::load_settings(std::vector{config::TextFile{std::move(name), std::string(text)}},
                               std::move(search));
}

}  // namespace mbgate::test

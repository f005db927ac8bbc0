// SPDX-License-Identifier: Apache-2.0
// The files of a configuration as they were read, not parsed yet.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace mbgate::config {

/// A configuration is written by hand; what is larger was named by mistake.
inline constexpr std::size_t kLargestFile = 1024UL * 1024UL;

struct TextFile {
  std::string name;       ///< the path of the file, as its diagnostics show it
  std::string text;       ///< what stands in it; of a file that is too large only the beginning
  std::string failure{};  ///< why there is no text; else empty
};

/// Reads one file.
TextFile read_text_file(const std::filesystem::path& path);

/// Reads the main file, and then the files *.toml of the folder conf.d beside it, in the order of
/// the bytes of their names. Hidden files are left out. Whatever else has such a name and is no
/// file, or cannot be read, is one with a failure; so is the folder itself, unless it is not there.
std::vector<TextFile> read_config_files(const std::filesystem::path& main);

}  // namespace mbgate::config

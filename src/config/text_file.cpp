// SPDX-License-Identifier: Apache-2.0
#include "config/text_file.hpp"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>

namespace mbgate::config {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFragmentFolder = "conf.d";

std::string unreadable(int error) {
  return "cannot be read: " +
         std::error_code(error == 0 ? EIO : error, std::generic_category()).message();
}

/// An editor's backup ends otherwise, or is hidden.
bool is_fragment_name(std::string_view name) {
  return name.ends_with(".toml") && !name.starts_with('.');
}

/// The names of the fragments in `folder`. No folder has none.
std::vector<std::string> fragment_names(const fs::path& folder, std::error_code& error) {
  std::vector<std::string> names;
  std::error_code ignored;
  if (fs::symlink_status(folder, ignored).type() == fs::file_type::not_found) {
    return names;
  }
  for (auto entry = fs::directory_iterator(folder, error);
       !error && entry != fs::directory_iterator(); entry.increment(error)) {
    auto name = entry->path().filename().string();
    if (is_fragment_name(name)) {
      names.push_back(std::move(name));
    }
  }
  std::ranges::sort(names);
  return names;
}

/// To open a pipe would wait for somebody who writes to it.
TextFile read_fragment(const fs::path& path) {
  std::error_code ignored;
  const auto status = fs::status(path, ignored);
  const bool is_other =
      fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
  return is_other ? TextFile{path.string(), {}, "is not a regular file"} : read_text_file(path);
}

}  // namespace

TextFile read_text_file(const fs::path& path) {
  TextFile file{path.string(), {}};
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) {
    file.failure = unreadable(EISDIR);
    return file;
  }
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) {
    file.failure = unreadable(errno);
    return file;
  }
  file.text.resize(kLargestFile + 1);
  stream.read(file.text.data(), static_cast<std::streamsize>(file.text.size()));
  if (stream.bad()) {
    file.failure = unreadable(errno);
  }
  file.text.resize(file.failure.empty() ? static_cast<std::size_t>(stream.gcount()) : 0);
  file.text.shrink_to_fit();
  return file;
}

std::vector<TextFile> read_config_files(const fs::path& main) {
  std::vector<TextFile> files{read_text_file(main)};
  const auto folder = main.parent_path() / kFragmentFolder;
  std::error_code error;
  for (const auto& name : fragment_names(folder, error)) {
    files.push_back(read_fragment(folder / name));
  }
  if (error) {
    files.push_back({folder.string(), {}, unreadable(error.value())});
  }
  return files;
}

}  // namespace mbgate::config

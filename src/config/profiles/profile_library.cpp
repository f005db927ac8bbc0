// SPDX-License-Identifier: Apache-2.0
#include "config/profiles/profile_library.hpp"

#include <algorithm>
#include <set>
#include <system_error>
#include <utility>

#include "config/toml/suggestion.hpp"
#include "config/toml/toml_value.hpp"

namespace mbgate::config {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kEnding = ".toml";

/// A name is no path: "../x" leads nowhere.
bool is_file_name(std::string_view name) {
  return !name.empty() && name.find('/') == std::string_view::npos &&
         name.find('\0') == std::string_view::npos && !name.starts_with('.');
}

std::unique_ptr<ProfileFile> generic() {
  auto file = std::make_unique<ProfileFile>();
  file->description = "Any Modbus device";
  file->manual = "MODBUS Application Protocol Specification V1.1b3";
  return file;
}

}  // namespace

fs::path ProfileLibrary::file_of(std::string_view name) const {
  if (!is_file_name(name)) {
    return {};
  }
  for (const auto& folder : folders_) {
    auto path = folder / (std::string(name).append(kEnding));
    std::error_code ignored;
    if (fs::exists(path, ignored)) {
      return path;
    }
  }
  return {};
}

bool ProfileLibrary::knows(std::string_view name) const {
  return name == kGenericProfile || !file_of(name).empty();
}

const ProfileFile* ProfileLibrary::find(std::string_view name) {
  if (const auto known = read_.find(name); known != read_.end()) {
    return known->second.get();
  }
  std::unique_ptr<ProfileFile> file;
  if (const auto path = file_of(name); !path.empty()) {
    const TextFile& text = files_.emplace(name, read_text_file(path)).first->second;
    auto loaded = load_profile(text);
    std::ranges::move(loaded.diagnostics, std::back_inserter(diagnostics_));
    if (loaded.file) {
      file = std::make_unique<ProfileFile>(*std::move(loaded.file));
    }
  } else if (name == kGenericProfile) {
    file = generic();
  }
  return read_.emplace(name, std::move(file)).first->second.get();
}

std::vector<TextFile> ProfileLibrary::files() const {
  std::vector<TextFile> files;
  for (const auto& [name, file] : files_) {
    files.push_back(file);
  }
  return files;
}

std::vector<std::string> ProfileLibrary::names() const {
  std::set<std::string> names{std::string(kGenericProfile)};
  for (const auto& folder : folders_) {
    std::error_code error;
    for (auto entry = fs::directory_iterator(folder, error);
         !error && entry != fs::directory_iterator(); entry.increment(error)) {
      if (entry->path().extension() == kEnding && is_file_name(entry->path().stem().string())) {
        names.insert(entry->path().stem().string());
      }
    }
  }
  return {names.begin(), names.end()};
}

std::string unknown_profile(const ProfileLibrary& library, std::string_view name) {
  std::string text = "no profile is named " + in_quotes(name);
  const auto names = library.names();
  const auto meant = did_you_mean(name, {names.begin(), names.end()});
  if (!meant.empty()) {
    return text + meant;
  }
  const bool any = names.size() > 1;
  text += any ? "; there are " : "; there is only \"generic\" in ";
  std::string separator;
  if (any) {
    for (const auto& known : names) {
      text += std::exchange(separator, ", ") + known;
    }
    return text;
  }
  for (const auto& folder : library.folders()) {
    text += std::exchange(separator, " and ") + folder.string();
  }
  return text;
}

}  // namespace mbgate::config

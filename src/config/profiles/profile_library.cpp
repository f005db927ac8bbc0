// SPDX-License-Identifier: Apache-2.0
#include "config/profiles/profile_library.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <ranges>
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

namespace fs = std::filesystem;

/// The folder of the running program; empty if nobody can say.
fs::path folder_of_program() {
  std::error_code error;
  const auto program = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::path() : program.parent_path();
}

/// The profiles of the sources, for programs in the folder of a build; empty if they are installed.
fs::path source_profiles(const fs::path& programs) {
  std::error_code ignored;
  auto profiles = (programs / MBGATE_SOURCE_PROFILES_FROM_PROGRAMS).lexically_normal();
  const bool is_build = !programs.empty() &&
                        fs::is_regular_file(programs.parent_path() / "CMakeCache.txt", ignored) &&
                        fs::is_directory(profiles, ignored);
  return is_build ? profiles : fs::path();
}

/// Beside the program, so that an installation works wherever it was put.
fs::path installed_profiles(const fs::path& programs) {
  auto beside = (programs / MBGATE_PROFILES_FROM_PROGRAMS).lexically_normal();
  std::error_code ignored;
  return !programs.empty() && fs::is_directory(beside, ignored)
             ? beside
             : fs::path(MBGATE_INSTALLED_PROFILES);
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
  const auto files = std::views::values(files_);
  return {files.begin(), files.end()};
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
  const std::string text = "no profile is named " + in_quotes(name);
  const auto names = library.names();
  const auto meant = did_you_mean(name, {names.begin(), names.end()});
  if (!meant.empty()) {
    return text + meant;
  }
  if (names.size() > 1) {
    return fmt::format("{}; there are {}", text, fmt::join(names, ", "));
  }
  const auto folders = std::views::transform(library.folders(), &fs::path::native);
  return fmt::format("{}; there is only \"generic\" in {}", text, fmt::join(folders, " and "));
}

// The only file that knows where the sources are, seen from a build, and where a build will be
// installed. No path of the build itself is in it: programs built in different folders are the
// same.

ProfileFolders default_profile_folders() {
  const auto programs = folder_of_program();
  if (auto profiles = source_profiles(programs); !profiles.empty()) {
    return {std::move(profiles)};
  }
  return {"/etc/mbgate/profiles", installed_profiles(programs)};
}

}  // namespace mbgate::config

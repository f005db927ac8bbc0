// SPDX-License-Identifier: Apache-2.0
// The only file that knows where the sources are, seen from a build, and where a build will be
// installed. No path of the build itself is in it: programs built in different folders are the
// same.
#include <system_error>
#include <utility>

#include "config/profiles/profile_library.hpp"

namespace mbgate::config {
namespace {

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

ProfileFolders default_profile_folders() {
  const auto programs = folder_of_program();
  if (auto profiles = source_profiles(programs); !profiles.empty()) {
    return {std::move(profiles)};
  }
  return {"/etc/mbgate/profiles", installed_profiles(programs)};
}

}  // namespace mbgate::config

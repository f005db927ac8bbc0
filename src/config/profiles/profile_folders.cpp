// SPDX-License-Identifier: Apache-2.0
// The only file that knows where this build was made and where it will be installed.
#include <system_error>

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

bool is_build_folder(const fs::path& folder) {
  std::error_code error;
  const auto built = fs::canonical(MBGATE_BUILT_PROGRAMS, error);
  return !error && folder == built;
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
  if (is_build_folder(programs)) {
    return {MBGATE_SOURCE_PROFILES};
  }
  return {"/etc/mbgate/profiles", installed_profiles(programs)};
}

}  // namespace mbgate::config

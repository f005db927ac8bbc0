// SPDX-License-Identifier: Apache-2.0
// The only file that knows where this build was made and where it will be installed.
#include <system_error>

#include "config/profile_library.hpp"

namespace mbgate::config {
namespace {

namespace fs = std::filesystem;

bool runs_from_its_build_folder() {
  std::error_code error;
  const auto program = fs::read_symlink("/proc/self/exe", error);
  const auto built = fs::canonical(MBGATE_BUILT_PROGRAMS, error);
  return !error && program.parent_path() == built;
}

}  // namespace

ProfileFolders default_profile_folders() {
  if (runs_from_its_build_folder()) {
    return {MBGATE_SOURCE_PROFILES};
  }
  return {"/etc/mbgate/profiles", MBGATE_INSTALLED_PROFILES};
}

}  // namespace mbgate::config

// SPDX-License-Identifier: Apache-2.0
// Profiles by their names: finds the file, reads it once, keeps it.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "config/diagnostic.hpp"
#include "config/profiles/profile_file.hpp"

namespace mbgate::config {

using ProfileFolders = std::vector<std::filesystem::path>;

/// The profile of a device that names none; it needs no file.
inline constexpr std::string_view kGenericProfile = "generic";

/// Where profiles are looked for if nobody says where: /etc/mbgate/profiles, so that a user's own
/// goes before a shipped one of the same name, then the installed ones. A program that runs out of
/// its build folder takes those of its source tree; an installed one never does.
ProfileFolders default_profile_folders();

class ProfileLibrary {
 public:
  /// The first of the folders that has a profile gives it.
  explicit ProfileLibrary(ProfileFolders folders) : folders_(std::move(folders)) {}

  /// Is there a file of that name, good or bad, or is it the generic one?
  [[nodiscard]] bool knows(std::string_view name) const;
  /// The profile; nullptr if there is none, or its file is wrong. Valid as long as the library.
  const ProfileFile* find(std::string_view name);
  /// Every name in every folder, in alphabetical order, the generic one included.
  [[nodiscard]] std::vector<std::string> names() const;
  [[nodiscard]] const ProfileFolders& folders() const { return folders_; }
  /// What was wrong in the files read so far, each once.
  [[nodiscard]] const std::vector<Diagnostic>& diagnostics() const { return diagnostics_; }

 private:
  [[nodiscard]] std::filesystem::path file_of(std::string_view name) const;

  ProfileFolders folders_;
  std::map<std::string, std::unique_ptr<ProfileFile>, std::less<>> read_;  // nullptr: wrong
  std::vector<Diagnostic> diagnostics_;
};

/// "no profile is named "x"; did you mean 'y'?", or which ones there are, or where none was found.
std::string unknown_profile(const ProfileLibrary& library, std::string_view name);

}  // namespace mbgate::config

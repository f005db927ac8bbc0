// SPDX-License-Identifier: Apache-2.0
// Finds profiles by name; each file is read once and kept.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "config/diagnostic.hpp"
#include "config/profiles/profile_file.hpp"
#include "config/text_file.hpp"

namespace mbgate::config {

using ProfileFolders = std::vector<std::filesystem::path>;

/// The profile of a device that names none; it needs no file.
inline constexpr std::string_view kGenericProfile = "generic";

/// Where profiles are looked for by default: first /etc/mbgate/profiles, so that a user's own
/// profile takes precedence over an installed one of the same name, then the installed ones. A
/// program that runs from its build folder uses those of its source tree; an installed one never
/// does.
ProfileFolders default_profile_folders();

class ProfileLibrary {
 public:
  /// A profile is taken from the first folder that has it.
  explicit ProfileLibrary(ProfileFolders folders) : folders_(std::move(folders)) {}

  /// Is there a file of that name, valid or not, or is it the generic profile?
  [[nodiscard]] bool knows(std::string_view name) const;
  /// The profile; nullptr if there is none or its file has errors. Valid as long as the library.
  const ProfileFile* find(std::string_view name);
  /// Every name in every folder, in alphabetical order, the generic one included.
  [[nodiscard]] std::vector<std::string> names() const;
  [[nodiscard]] const ProfileFolders& folders() const { return folders_; }
  /// What was wrong in the files read so far, each file once.
  [[nodiscard]] const std::vector<Diagnostic>& diagnostics() const { return diagnostics_; }
  /// The files read so far, by the names of their profiles.
  [[nodiscard]] std::vector<TextFile> files() const;

 private:
  [[nodiscard]] std::filesystem::path file_of(std::string_view name) const;

  ProfileFolders folders_;
  std::map<std::string, std::unique_ptr<ProfileFile>, std::less<>> read_;  // nullptr: wrong
  std::vector<Diagnostic> diagnostics_;
  std::map<std::string, TextFile, std::less<>> files_;
};

/// "no profile is named "x"; did you mean 'y'?", or which ones there are, or where none was found.
std::string unknown_profile(const ProfileLibrary& library, std::string_view name);

}  // namespace mbgate::config

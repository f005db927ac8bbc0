// SPDX-License-Identifier: Apache-2.0
// What belongs to `mbgatectl profile` on the command line, and the folder of the profiles.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "ctl/request/command.hpp"

namespace CLI {  // NOLINT(readability-identifier-naming): the library is named so
class App;
}

namespace mbgate::ctl {

/// `command` keeps a reference to `folder`.
void add_profile_folder(CLI::App& command, std::optional<std::filesystem::path>& folder);

class ProfileOptions {
 public:
  explicit ProfileOptions(CLI::App& app);
  ProfileOptions(const ProfileOptions&) = delete;
  ProfileOptions& operator=(const ProfileOptions&) = delete;

  [[nodiscard]] bool given() const;
  [[nodiscard]] Result<Command, std::string> command() const { return Command(words_); }

 private:
  CLI::App* profile_;
  ProfileCommand words_;
};

}  // namespace mbgate::ctl

// SPDX-License-Identifier: Apache-2.0
#include "ctl/options/profile_options.hpp"

#include <CLI/CLI.hpp>

namespace mbgate::ctl {

void add_profile_folder(CLI::App& command, std::optional<std::filesystem::path>& folder) {
  command
      .add_option("--profiles", folder,
                  "look in this folder only, instead of /etc/mbgate/profiles and the installed "
                  "ones")
      ->type_name("DIR")
      ->check(CLI::ExistingDirectory);
}

ProfileOptions::ProfileOptions(CLI::App& app)
    : profile_(app.add_subcommand("profile",
                                  "Show what is known of a kind of drive, or list all kinds.")) {
  profile_->add_option("name", words_.which, "of a profile, or a file; none: list all");
  add_profile_folder(*profile_, words_.folder);
  profile_->add_flag("--json", words_.json, "for programs");
}

bool ProfileOptions::given() const { return profile_->parsed(); }

}  // namespace mbgate::ctl

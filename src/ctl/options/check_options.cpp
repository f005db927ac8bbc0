// SPDX-License-Identifier: Apache-2.0
#include "ctl/options/check_options.hpp"

#include <CLI/CLI.hpp>

#include "ctl/options/profile_options.hpp"

namespace mbgate::ctl {

CheckOptions::CheckOptions(CLI::App& app)
    : check_(app.add_subcommand(
          "check",
          "Say what is wrong with a configuration, as mbgated --check does. No port is opened.")) {
  check_
      ->add_option("file", words_.config,
                   "the configuration file; those of conf.d beside it are read too")
      ->capture_default_str();
  add_profile_folder(*check_, words_.folder);
}

bool CheckOptions::given() const { return check_->parsed(); }

}  // namespace mbgate::ctl

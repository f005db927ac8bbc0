// SPDX-License-Identifier: Apache-2.0
// Subcommands that only read files.
#include <CLI/CLI.hpp>
#include <memory>

#include "ctl/options/shared_options.hpp"

namespace mbgate::ctl {

void add_profile(CLI::App& app, const Choose& choose) {
  auto* profile = app.add_subcommand("profile", "Show a drive profile, or list all of them.");
  const auto words = std::make_shared<ProfileCommand>();
  profile->add_option("name", words->which, "name or file of a profile; default: list all");
  add_profile_folder(*profile, words->folder);
  profile->add_flag("--json", words->json, "for programs");
  profile->callback([words, choose] { choose(*words); });
}

void add_check(CLI::App& app, const Choose& choose) {
  auto* check = app.add_subcommand(
      "check", "Report the errors of a configuration, as mbgated --check does. No port is opened.");
  const auto words = std::make_shared<CheckCommand>();
  check
      ->add_option("file", words->config,
                   "the configuration file; those of conf.d beside it are read too")
      ->capture_default_str();
  add_profile_folder(*check, words->folder);
  check->callback([words, choose] { choose(*words); });
}

void add_replay(CLI::App& app, const Choose& choose) {
  auto* replay = app.add_subcommand(
      "replay",
      "Replay a recording of mbgated, and report where this version first does something else. No "
      "port is opened.");
  const auto words = std::make_shared<ReplayCommand>();
  replay->add_option("file", words->recording, "a recording of mbgated --record")->required();
  add_profile_folder(*replay, words->folder);
  replay->callback([words, choose] { choose(*words); });
}

}  // namespace mbgate::ctl

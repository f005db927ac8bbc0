// SPDX-License-Identifier: Apache-2.0
#include "ctl/options/replay_options.hpp"

#include <CLI/CLI.hpp>

#include "ctl/options/profile_options.hpp"

namespace mbgate::ctl {

ReplayOptions::ReplayOptions(CLI::App& app)
    : replay_(app.add_subcommand(
          "replay",
          "Say whether this version does what a recorded mbgated did, or where it first does "
          "something else. No port is opened.")) {
  replay_->add_option("file", words_.recording, "a recording of mbgated --record")->required();
  add_profile_folder(*replay_, words_.folder);
}

bool ReplayOptions::given() const { return replay_->parsed(); }

}  // namespace mbgate::ctl

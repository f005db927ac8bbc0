// SPDX-License-Identifier: Apache-2.0
#include "ctl/options/control_options.hpp"

#include <CLI/CLI.hpp>

namespace mbgate::ctl {
namespace {

void add_control(CLI::App& command, std::string& socket) {
  command.add_option("--control", socket, "the control socket of mbgated, its [http] socket")
      ->type_name("PATH")
      ->capture_default_str();
}

}  // namespace

StatusOptions::StatusOptions(CLI::App& app)
    : status_(app.add_subcommand(
          "status",
          "Show how a running mbgated, its lines and its drives are: what is not well first.")) {
  status_->add_flag("--json", words_.json, "for programs");
  add_control(*status_, words_.socket);
}

bool StatusOptions::given() const { return status_->parsed(); }

ReloadOptions::ReloadOptions(CLI::App& app)
    : reload_(app.add_subcommand(
          "reload",
          "Have a running mbgated read its configuration again, and say what has changed or why "
          "it was refused.")) {
  add_control(*reload_, words_.socket);
}

bool ReloadOptions::given() const { return reload_->parsed(); }

}  // namespace mbgate::ctl

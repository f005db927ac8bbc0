// SPDX-License-Identifier: Apache-2.0
// The SHA-256 of the configuration's files, by which an operator can tell whether the settings in
// force are those on the disk.
#pragma once

#include <string>
#include <vector>

#include "config/text_file.hpp"

namespace mbgate::app {

/// Of the files one behind the other: the main file, those of conf.d, those of the profiles that it
/// uses, in the order of digest_command().
std::string config_digest(const std::vector<config::TextFile>& files);

/// What says the same in a shell: "cat /etc/mbgate/mbgate.toml ... | sha256sum".
std::string digest_command(const std::vector<config::TextFile>& files);

/// For the journal. `before`: of the configuration that was in force until now; empty: there was
/// none.
std::string in_force_text(const std::string& digest, const std::string& before = {});

}  // namespace mbgate::app

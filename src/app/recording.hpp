// SPDX-License-Identifier: Apache-2.0
// Where a recording goes (mbgated --record), and what it begins with.
#pragma once

#include <filesystem>
#include <string>

#include "io/unique_fd.hpp"
#include "modbus/result.hpp"

namespace mbgate::app {

/// A relative path is meant below the service's state directory ($STATE_DIRECTORY of systemd.exec,
/// the first one), or where there is none (null or empty), below the working directory.
std::filesystem::path recording_path(const std::filesystem::path& file,
                                     const char* state_directory);

/// A new file that only its owner can read: it will hold all data of the process. An older
/// recording there becomes FILE.1, because a restart after a crash must not destroy what led to
/// it. An error says which file it was.
Result<io::UniqueFd, std::string> create_recording(const std::filesystem::path& file);

/// The text of a configuration file, to be loaded and recorded alike; empty if it cannot be read.
std::string read_text(const std::filesystem::path& file);

}  // namespace mbgate::app

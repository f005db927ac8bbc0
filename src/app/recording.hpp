// SPDX-License-Identifier: Apache-2.0
// The file of a recording (mbgated --record), and its head.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "config/text_file.hpp"
#include "modbus/result.hpp"
#include "report/recording/record.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::app {

/// Resolves the path of a recording: a relative one is below the service's state directory (the
/// first one in $STATE_DIRECTORY of systemd.exec) or, if there is none (null or empty), below the
/// working directory.
std::filesystem::path recording_path(const std::filesystem::path& file,
                                     const char* state_directory);

/// Creates a file that only its owner can read, because it will hold all process data. An older
/// recording of that name becomes FILE.1: a restart after a crash must not destroy the recording of
/// the crash. The error names the file.
Result<sys::UniqueFd, std::string> create_recording(const std::filesystem::path& file);

/// The text when creating it has failed with `error`: what the system said, and what helps.
std::string recording_failure(const std::filesystem::path& file, int error);

/// The files of a configuration as a recording holds them: with paths that hold everywhere.
std::vector<report::ConfigFile> recorded_files(const std::vector<config::TextFile>& files);

}  // namespace mbgate::app

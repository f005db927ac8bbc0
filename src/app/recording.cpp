// SPDX-License-Identifier: Apache-2.0
#include "app/recording.hpp"

#include <fcntl.h>

#include <cerrno>
#include <fmt/core.h>
#include <string_view>
#include <system_error>

#include "io/advice.hpp"

namespace mbgate::app {

namespace fs = std::filesystem;

fs::path recording_path(const fs::path& file, const char* state_directory) {
  const std::string_view all = state_directory == nullptr ? "" : state_directory;
  return fs::path(all.substr(0, all.find(':'))) / file;
}

Result<sys::UniqueFd, std::string> create_recording(const fs::path& file) {
  std::error_code ignored;
  if (fs::is_regular_file(file, ignored)) {
    fs::rename(file, file.string() + ".1", ignored);
  }
  constexpr mode_t kOwnerOnly = 0600;
  sys::UniqueFd created(
      ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOCTTY, kOwnerOnly));
  if (!created.is_open()) {
    return recording_failure(file, errno);
  }
  return created;
}

std::string recording_failure(const fs::path& file, int error) {
  const std::string folder = file.has_parent_path() ? file.parent_path().string() : ".";
  return fmt::format(
      "cannot create the recording {}: {}{}", file.string(), std::generic_category().message(error),
      io::folder_advice(
          folder, error,
          "name a FILE without a folder, which goes to the state directory, /var/lib/mbgate"));
}

std::vector<report::ConfigFile> recorded_files(const std::vector<config::TextFile>& files) {
  std::vector<report::ConfigFile> recorded;
  recorded.reserve(files.size());
  for (const auto& file : files) {
    recorded.push_back({fs::absolute(file.name).string(), file.text});
  }
  return recorded;
}

}  // namespace mbgate::app

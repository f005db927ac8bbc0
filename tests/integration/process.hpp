// SPDX-License-Identifier: Apache-2.0
// A program under test: started with its own working directory, watched by its standard error,
// ended by its id.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace mbgate::test {

/// Nothing in these tests may take longer; what does is broken.
inline constexpr std::chrono::seconds kPatience{30};

/// A folder that is removed with everything in it.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Writes a file and returns its path.
  std::filesystem::path write(const std::string& name, const std::string& text) const;

 private:
  std::filesystem::path path_;
};

class Process {
 public:
  struct Options {
    std::filesystem::path folder;
    /// Runs in the child before the program; for file descriptors and variables.
    std::function<void()> prepare;
  };

  /// `program` is one of ours; its folder is the build's.
  Process(const std::string& program, const std::vector<std::string>& arguments,
          const Options& options);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// The first line, old or new, that contains `text`; fails the test after kPatience.
  std::string wait_for_line(const std::string& text);
  /// The port behind "listening NAME ADDRESS:".
  std::uint16_t port_of(const std::string& listener);
  void signal(int number) const;
  /// The exit status, or nothing if it did not end in time.
  std::optional<int> wait_for_exit(std::chrono::milliseconds limit = kPatience);
  [[nodiscard]] pid_t pid() const { return pid_; }
  /// Everything it has printed so far.
  std::string output();

 private:
  bool read_more(std::chrono::milliseconds limit);

  pid_t pid_ = -1;
  int output_ = -1;
  std::string text_;
};

/// Resident memory of a process in bytes.
std::size_t resident_memory(pid_t pid);

}  // namespace mbgate::test

// SPDX-License-Identifier: Apache-2.0
// A process of the harness: what is measured, and what loads it.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>

#include "samples.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::bench {

/// What the kernel says of a process.
struct Usage {
  Nanoseconds processor{0};  ///< user and system, of all its threads
  unsigned long context_switches =
      0;                     ///< of all its threads: how often one was woken, or displaced
  std::size_t resident = 0;  ///< bytes
};

/// Ends with its owner: asked first (SIGTERM), and after a second not asked any more.
class Child {
 public:
  /// A copy of this process that runs `body` with the end of a pipe to write to, and exits. To be
  /// called while there is no other thread. Throws std::system_error.
  static Child run(const std::function<void(int output)>& body);
  /// A command of the shell, its standard output and errors going to a new file.
  static Child command(const std::string& text, const std::filesystem::path& log);

  Child(Child&& other) noexcept;
  Child& operator=(Child&&) = delete;
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child();

  /// Reads so many bytes of what `body` writes; false if it ends or the time is over before.
  [[nodiscard]] bool receive(void* data, std::size_t size, std::chrono::milliseconds limit) const;
  /// False once it has exited.
  [[nodiscard]] bool lives() const;
  [[nodiscard]] Usage usage() const;

 private:
  Child(pid_t process, sys::UniqueFd output);

  pid_t process_;
  sys::UniqueFd output_;
};

}  // namespace mbgate::bench

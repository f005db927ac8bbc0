// SPDX-License-Identifier: Apache-2.0
#include "child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <system_error>
#include <thread>
#include <utility>

namespace mbgate::bench {
namespace {

constexpr std::chrono::milliseconds kGrace{1000};
constexpr std::chrono::milliseconds kLook{10};

/// Forks; in the child `body` runs with the pipe's end, and the child exits.
std::pair<pid_t, sys::UniqueFd> fork_with_pipe(const std::function<void(int)>& body) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) {
    throw std::system_error(errno, std::generic_category(), "pipe");
  }
  sys::UniqueFd reading(ends[0]);
  const sys::UniqueFd writing(ends[1]);
  std::cout.flush();
  const pid_t parent = ::getpid();
  const pid_t process = ::fork();
  if (process < 0) {
    throw std::system_error(errno, std::generic_category(), "fork");
  }
  if (process > 0) {
    return {process, std::move(reading)};
  }
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() == parent) {
    reading.reset(-1);
    try {
      body(writing.get());
    } catch (const std::exception& error) {
      std::cerr << "mbgate-bench: " << error.what() << std::endl;
      ::_exit(1);
    }
  }
  ::_exit(0);
}

/// The number behind `name` in a file of /proc such as status; 0 if it is not there.
unsigned long number_in(const std::filesystem::path& file, const std::string& name) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with(name + ":")) {
      return std::strtoul(line.c_str() + name.size() + 1, nullptr, 10);
    }
  }
  return 0;
}

}  // namespace

Child::Child(pid_t process, sys::UniqueFd output) : process_(process), output_(std::move(output)) {}

Child::Child(Child&& other) noexcept
    : process_(std::exchange(other.process_, 0)), output_(std::move(other.output_)) {}

Child Child::run(const std::function<void(int output)>& body) {
  auto [process, output] = fork_with_pipe(body);
  return {process, std::move(output)};
}

Child Child::command(const std::string& text, const std::filesystem::path& log) {
  return run([&](int /*output*/) {
    const int file = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    ::dup2(file, STDOUT_FILENO);
    ::dup2(file, STDERR_FILENO);
    // The shell's place is taken by the command, so that what is measured is not a shell.
    ::execl("/bin/sh", "sh", "-c", ("exec " + text).c_str(), nullptr);
  });
}

Child::~Child() {
  if (process_ == 0) {
    return;
  }
  ::kill(process_, SIGTERM);
  for (auto left = kGrace; left > kGrace.zero(); left -= kLook) {
    if (::waitpid(process_, nullptr, WNOHANG) != 0) {
      return;
    }
    std::this_thread::sleep_for(kLook);
  }
  ::kill(process_, SIGKILL);
  ::waitpid(process_, nullptr, 0);
}

bool Child::receive(void* data, std::size_t size, std::chrono::milliseconds limit) const {
  const auto end = std::chrono::steady_clock::now() + limit;
  auto* place = static_cast<char*>(data);
  while (size > 0) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        end - std::chrono::steady_clock::now());
    pollfd descriptor{output_.get(), POLLIN, 0};
    if (left.count() <= 0 || ::poll(&descriptor, 1, static_cast<int>(left.count())) <= 0) {
      return false;
    }
    const ssize_t count = ::read(output_.get(), place, size);
    if (count <= 0) {
      return false;
    }
    place += count;
    size -= static_cast<std::size_t>(count);
  }
  return true;
}

bool Child::lives() const {
  siginfo_t state{};
  return ::waitid(P_PID, static_cast<id_t>(process_), &state, WEXITED | WNOHANG | WNOWAIT) == 0 &&
         state.si_pid == 0;
}

Usage Child::usage() const {
  Usage usage;
  clockid_t clock{};
  timespec used{};
  if (::clock_getcpuclockid(process_, &clock) == 0 && ::clock_gettime(clock, &used) == 0) {
    usage.processor = std::chrono::seconds(used.tv_sec) + Nanoseconds(used.tv_nsec);
  }
  const std::filesystem::path folder = "/proc/" + std::to_string(process_);
  usage.resident = number_in(folder / "status", "VmRSS") * 1024;
  std::error_code error;
  for (const auto& thread : std::filesystem::directory_iterator(folder / "task", error)) {
    usage.context_switches += number_in(thread.path() / "status", "voluntary_ctxt_switches") +
                              number_in(thread.path() / "status", "nonvoluntary_ctxt_switches");
  }
  return usage;
}

}  // namespace mbgate::bench

// SPDX-License-Identifier: Apache-2.0
#include "integration/process.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <stdexcept>
#include <thread>

namespace mbgate::test {
namespace {

using Clock = std::chrono::steady_clock;

std::chrono::milliseconds left_until(Clock::time_point end) {
  return std::max(std::chrono::milliseconds(0),
                  std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()));
}

}  // namespace

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "mbgate-test-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) {
    throw std::runtime_error("no temporary folder");
  }
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::filesystem::path TemporaryFolder::write(const std::string& name,
                                             const std::string& text) const {
  std::ofstream(path_ / name) << text;
  return path_ / name;
}

Process::Process(const std::string& program, const std::vector<std::string>& arguments,
                 const Options& options) {
  int pipes[2];
  if (pipe2(pipes, O_CLOEXEC) != 0) {
    throw std::runtime_error("no pipe");
  }
  const std::string path = std::string(MBGATE_PROGRAMS) + "/" + program;
  std::vector<char*> argv{const_cast<char*>(path.c_str())};
  for (const auto& argument : arguments) {
    argv.push_back(const_cast<char*>(argument.c_str()));
  }
  argv.push_back(nullptr);
  pid_ = fork();
  if (pid_ == 0) {
    dup2(pipes[1], STDOUT_FILENO);
    dup2(pipes[1], STDERR_FILENO);
    if (options.prepare) {
      options.prepare();
    }
    if (chdir(options.folder.c_str()) == 0) {
      execv(path.c_str(), argv.data());
    }
    _exit(127);
  }
  close(pipes[1]);
  output_ = pipes[0];
}

Process::~Process() {
  if (pid_ > 0) {
    signal(SIGTERM);
    if (!wait_for_exit(std::chrono::seconds(5))) {
      signal(SIGKILL);
      wait_for_exit();
    }
  }
  close(output_);
}

void Process::signal(int number) const {
  if (pid_ > 0) {
    kill(pid_, number);
  }
}

bool Process::read_more(std::chrono::milliseconds limit) {
  pollfd watched{output_, POLLIN, 0};
  if (poll(&watched, 1, static_cast<int>(limit.count())) <= 0) {
    return false;
  }
  char buffer[4096];
  const ssize_t count = read(output_, buffer, sizeof buffer);
  if (count <= 0) {
    return false;
  }
  text_.append(buffer, static_cast<std::size_t>(count));
  return true;
}

std::string Process::wait_for_line(const std::string& text) {
  const auto end = Clock::now() + kPatience;
  for (;;) {
    const auto found = text_.find(text);
    const auto line_end = found == std::string::npos ? found : text_.find('\n', found);
    if (line_end != std::string::npos) {
      const auto before = text_.rfind('\n', found);
      const auto begin = before == std::string::npos ? 0 : before + 1;
      return text_.substr(begin, line_end - begin);
    }
    if (!read_more(left_until(end))) {
      ADD_FAILURE() << "waited in vain for \"" << text << "\" in:\n" << text_;
      return {};
    }
  }
}

std::uint16_t Process::port_of(const std::string& listener) {
  const std::string line = wait_for_line("listening " + listener + " ");
  const auto colon = line.rfind(':');
  return colon == std::string::npos ? std::uint16_t{0}
                                    : static_cast<std::uint16_t>(std::stoi(line.substr(colon + 1)));
}

std::optional<int> Process::wait_for_exit(std::chrono::milliseconds limit) {
  const auto end = Clock::now() + limit;
  int status = 0;
  while (waitpid(pid_, &status, WNOHANG) == 0) {
    if (Clock::now() >= end) {
      return std::nullopt;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  pid_ = -1;
  while (read_more(std::chrono::milliseconds(0))) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

std::string Process::output() {
  while (read_more(std::chrono::milliseconds(0))) {
  }
  return text_;
}

std::size_t resident_memory(pid_t pid) {
  std::ifstream statm("/proc/" + std::to_string(pid) + "/statm");
  std::size_t whole = 0;
  std::size_t resident = 0;
  statm >> whole >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace mbgate::test

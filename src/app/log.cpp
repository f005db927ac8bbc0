// SPDX-License-Identifier: Apache-2.0
#include "app/log.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <boost/asio/post.hpp>
#include <cerrno>
#include <cstdlib>
#include <future>
#include <memory>
#include <string_view>
#include <utility>

#include "io/clock.hpp"

namespace mbgate::app {
namespace {

/// Lines held for a standard error that does not take them: some 100 KiB.
constexpr std::size_t kMostWaiting = 1000;

void write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(descriptor, text.data(), text.size());
    if (count < 0 && errno != EINTR) {
      return;  // nobody is left to tell
    }
    text.remove_prefix(count < 0 ? 0 : static_cast<std::size_t>(count));
  }
}

}  // namespace

const char* level_word(Level level) {
  switch (level) {
    case Level::error: return "error";
    case Level::warning: return "warning";
    case Level::notice: return "notice";
    case Level::info: return "info";
  }
  return "";
}

bool is_standard_error_the_journal() {
  const char* const stream = std::getenv("JOURNAL_STREAM");
  struct stat status {};
  if (stream == nullptr || ::fstat(STDERR_FILENO, &status) != 0) {
    return false;
  }
  return std::to_string(status.st_dev) + ":" + std::to_string(status.st_ino) == stream;
}

std::string log_line(Level level, const std::string& text, bool for_journal) {
  return for_journal ? "<" + std::to_string(static_cast<int>(level)) + ">" + text
                     : std::string(level_word(level)) + ": " + text;
}

Log::Log(bool for_journal, int descriptor) : for_journal_(for_journal), descriptor_(descriptor) {}

void Log::write(Level level, const std::string& text) {
  give(level, text, log_line(level, text, for_journal_));
}

void Log::write_limited(Level level, const std::string& kind, const std::string& text) {
  const auto verdict = limit_.count(kind, io::now());
  if (!verdict.write) {
    return;
  }
  std::string line = text;
  if (verdict.left_out > 0) {
    line += " (" + std::to_string(verdict.left_out) + " lines of this kind were left out)";
  }
  if (verdict.last) {
    line += " (more of this kind within a minute are only counted)";
  }
  write(level, line);
}

void Log::print(std::string line) {
  const std::string text = line;
  give(Level::info, text, std::move(line));
}

void Log::give(Level level, const std::string& text, std::string line) {
  if (waiting_ >= kMostWaiting) {
    ++lost_;
    return;
  }
  line += '\n';
  std::string missing;
  if (lost_ > 0) {
    missing = std::to_string(std::exchange(lost_, 0)) +
              " lines are missing here: standard error did not take them";
    line += log_line(Level::warning, missing, for_journal_) + '\n';
  }
  ++waiting_;
  boost::asio::post(writer_, [this, line = std::move(line)] {
    write_all(descriptor_, line);
    --waiting_;
  });
  if (observer_) {
    observer_(level, text);
    if (!missing.empty()) {
      observer_(Level::warning, missing);
    }
  }
}

bool Log::flush(std::chrono::milliseconds limit) {
  const auto written = std::make_shared<std::promise<void>>();
  boost::asio::post(writer_, [written] { written->set_value(); });
  return written->get_future().wait_for(limit) == std::future_status::ready;
}

}  // namespace mbgate::app

// SPDX-License-Identifier: Apache-2.0
#include "app/log.hpp"

#include <unistd.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <fmt/core.h>
#include <future>
#include <memory>

#include "io/clock.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::app {
namespace {

/// Lines held for a standard error that does not take them: some 100 KiB.
constexpr std::size_t kMostWaiting = 1000;

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

std::string log_line(Level level, const std::string& text, bool for_journal) {
  return for_journal ? fmt::format("<{}>{}", static_cast<int>(level), text)
                     : fmt::format("{}: {}", level_word(level), text);
}

Log::Log(bool for_journal, int descriptor, Send send)
    : for_journal_(for_journal), descriptor_(descriptor), send_(std::move(send)) {}

void Log::write(Level level, const std::string& text, const Topic& topic) {
  give(level, text, log_line(level, text, for_journal_), topic);
}

void Log::write_unobserved(Level level, const std::string& text, const Topic& topic) {
  give(level, text, log_line(level, text, for_journal_), topic, false);
}

void Log::write_limited(Level level, const std::string& kind, const std::string& text,
                        const Topic& topic) {
  const auto verdict = limit_.count(kind, io::now());
  if (!verdict.write) {
    return;
  }
  std::string line = text;
  if (verdict.left_out > 0) {
    line += fmt::format(" ({} lines of this kind were left out)", verdict.left_out);
  }
  if (verdict.last) {
    line += " (more of this kind within a minute are only counted)";
  }
  write(level, line, topic);
}

void Log::print(std::string line, const Topic& topic) {
  const std::string text = line;
  give(Level::info, text, std::move(line), topic);
}

void Log::give(Level level, const std::string& text, std::string line, const Topic& topic,
               bool is_observed) {
  if (waiting_ >= kMostWaiting) {
    ++lost_;
    return;
  }
  std::vector<Entry> entries{entry_of(level, text, std::move(line), topic)};
  std::string missing;
  if (lost_ > 0) {
    missing = fmt::format("{} lines are missing here: {} did not accept them fast enough",
                          std::exchange(lost_, 0), for_journal_ ? "the journal" : "standard error");
    entries.push_back(entry_of(Level::warning, missing,
                               log_line(Level::warning, missing, for_journal_),
                               {.id = message_id::kLinesMissing}));
  }
  ++waiting_;
  boost::asio::post(writer_, [this, entries = std::move(entries)] {
    std::ranges::for_each(entries, [this](const Entry& entry) { deliver(entry); });
    --waiting_;
  });
  if (observer_) {
    if (is_observed) {
      observer_(level, text);
    }
    if (!missing.empty()) {
      observer_(Level::warning, missing);
    }
  }
}

Log::Entry Log::entry_of(Level level, const std::string& text, std::string line,
                         const Topic& topic) const {
  line += '\n';
  return {for_journal_ ? journal_fields(level, text, topic) : std::vector<std::string>(),
          std::move(line)};
}

void Log::deliver(const Entry& entry) const {
  if (!for_journal_ || !send_(entry.fields)) {
    sys::write_all(descriptor_, entry.line);
  }
}

bool Log::flush(std::chrono::milliseconds limit) {
  const auto written = std::make_shared<std::promise<void>>();
  boost::asio::post(writer_, [written] { written->set_value(); });
  return written->get_future().wait_for(limit) == std::future_status::ready;
}

RateLimit::Verdict RateLimit::count(const std::string& kind, bus::Instant now) {
  Window& window = windows_.try_emplace(kind, Window{now}).first->second;
  if (now - window.begin >= kWindow) {
    window.begin = now;
    window.lines = 0;
  }
  if (window.lines == kLinesPerWindow) {
    ++window.left_out;
    return {};
  }
  ++window.lines;
  return {true, window.lines == kLinesPerWindow, std::exchange(window.left_out, 0)};
}

}  // namespace mbgate::app

// SPDX-License-Identifier: Apache-2.0
// Lines for the operator, on standard error: with a priority prefix if the journal reads it,
// otherwise with a word. A thread of its own writes them, because a blocked journal must not stop a
// bus.
#pragma once

#include <atomic>
#include <boost/asio/thread_pool.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "app/rate_limit.hpp"

namespace mbgate::app {

/// The numbers are those of syslog(3).
enum class Level : std::uint8_t { error = 3, warning = 4, notice = 5, info = 6 };

/// "error", "warning", "notice" or "info".
const char* level_word(Level level);

/// Is standard error the stream that systemd connected to the journal (JOURNAL_STREAM in
/// systemd.exec)?
bool is_standard_error_the_journal();

/// One line without its end: "<4>text" for the journal, "warning: text" for people.
std::string log_line(Level level, const std::string& text, bool for_journal);

class Log {
 public:
  /// Told of every line that is given to the writer, on the thread that hands it in. What print()
  /// takes is info: so the journal has it.
  using Observer = std::function<void(Level, const std::string& text)>;

  explicit Log(bool for_journal, int descriptor = 2);
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;
  ~Log() = default;

  void write(Level level, const std::string& text);
  /// The same, at most ten times a minute for one `kind`. Further lines are counted, and the count
  /// is written.
  void write_limited(Level level, const std::string& kind, const std::string& text);
  /// One at a time; an empty one ends it.
  void observe(Observer observer) { observer_ = std::move(observer); }
  /// The line exactly as it is.
  void print(std::string line);
  /// Waits until all lines are written. False if that takes longer than `limit`.
  bool flush(std::chrono::milliseconds limit);

 private:
  /// `line` is `text` as it is written.
  void give(Level level, const std::string& text, std::string line);

  bool for_journal_;
  int descriptor_;
  RateLimit limit_;
  Observer observer_;
  std::atomic<std::size_t> waiting_ = 0;  ///< lines that the writer has not written yet
  std::size_t lost_ = 0;                  ///< lines dropped because too many were waiting
  boost::asio::thread_pool writer_{1};
};

}  // namespace mbgate::app

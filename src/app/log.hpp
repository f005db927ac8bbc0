// SPDX-License-Identifier: Apache-2.0
// Lines for the operator: entries with fields if the journal reads standard error, otherwise lines
// there with a word before them. A thread of its own writes them, because a blocked journal must
// not stop a bus.
#pragma once

#include <atomic>
#include <boost/asio/thread_pool.hpp>
#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "app/journal/journal.hpp"
#include "bus/instant.hpp"

namespace mbgate::app {

/// Limits the log lines of one kind: a peer or an adapter that fails again and again must not fill
/// the journal. Pure: the time is handed in.
class RateLimit {
 public:
  static constexpr std::size_t kLinesPerWindow = 10;
  static constexpr bus::Duration kWindow = std::chrono::minutes(1);

  struct Verdict {
    bool write = false;
    /// This line is the last one of its kind before a silence; it should say so.
    bool last = false;
    /// Lines of this kind that were left out since the last one written.
    std::size_t left_out = 0;
  };

  /// Counts one line of a kind. Kinds are few: an event and the bus or listener it belongs to.
  Verdict count(const std::string& kind, bus::Instant now);

 private:
  struct Window {
    bus::Instant begin;
    std::size_t lines = 0;
    std::size_t left_out = 0;
  };
  std::map<std::string, Window> windows_;
};

/// "error", "warning", "notice" or "info".
const char* level_word(Level level);

/// One line without its end: "<4>text" for what reads standard error in place of the journal (see
/// sd-daemon(3)), "warning: text" for people.
std::string log_line(Level level, const std::string& text, bool for_journal);

class Log {
 public:
  /// Called for every line that is given to the writer, except by write_unobserved(), on the thread
  /// that gives it. A line of print() has the level info, as in the journal.
  using Observer = std::function<void(Level, const std::string& text)>;

  /// send_to_journal(), or a test's replacement for it.
  using Send = std::function<bool(const std::vector<std::string>& fields)>;

  /// Lines that cannot be sent to the journal are written to the descriptor.
  explicit Log(bool for_journal, int descriptor = 2, Send send = send_to_journal);
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;
  ~Log() = default;

  void write(Level level, const std::string& text, const Topic& topic = {});
  /// The same, at most ten times a minute for one `kind`. Further lines are counted, and the count
  /// is written.
  void write_limited(Level level, const std::string& kind, const std::string& text,
                     const Topic& topic = {});
  /// For the journal alone: the observer is not called, because its readers keep what somebody has
  /// to act on, and this may come many times a second.
  void write_unobserved(Level level, const std::string& text, const Topic& topic = {});
  /// One at a time; an empty one ends it.
  void observe(Observer observer) { observer_ = std::move(observer); }
  /// The line exactly as it is; for the journal it is info.
  void print(std::string line, const Topic& topic = {});
  /// Waits until all lines are written. False if that takes longer than `limit`: then only
  /// std::_Exit() ends the process, because the writer waits for the journal.
  bool flush(std::chrono::milliseconds limit);

 private:
  /// `line` is `text` as it is written on standard error.
  void give(Level level, const std::string& text, std::string line, const Topic& topic,
            bool is_observed = true);
  /// Made on the thread that hands it in, so that the writer needs no memory.
  struct Entry {
    std::vector<std::string> fields;  ///< empty if it is not for the journal
    std::string line;
  };
  [[nodiscard]] Entry entry_of(Level level, const std::string& text, std::string line,
                               const Topic& topic) const;
  void deliver(const Entry& entry) const;

  bool for_journal_;
  int descriptor_;
  Send send_;
  RateLimit limit_;
  Observer observer_;
  std::atomic<std::size_t> waiting_ = 0;  ///< lines that the writer has not written yet
  std::size_t lost_ = 0;                  ///< lines dropped because too many were waiting
  boost::asio::thread_pool writer_{1};
};

}  // namespace mbgate::app

// SPDX-License-Identifier: Apache-2.0
// Which records of a trace a reader asks for.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>

#include "gateway/trace/trace_record.hpp"
#include "modbus/result.hpp"

namespace mbgate::app {

struct TraceFilter {
  std::optional<std::string> bus;     ///< name; it was to go there, or was heard there
  std::optional<std::string> device;  ///< name; it was to go there
  std::optional<routing::ClientAddress> client;
  std::optional<std::uint8_t> function;  ///< of the request
  bool only_failed = false;
  bool with_journal = false;  ///< what the journal gets comes too

  /// `query`: what stands behind the '?' of a request. The error names the word, and says what is
  /// expected.
  static Result<TraceFilter, std::string> parse(std::string_view query);

  /// A record that does not say what is asked for does not match: bytes that nobody had asked for
  /// have no client.
  [[nodiscard]] bool matches(const gateway::TraceRecord& record) const;
};

// The last records of a trace, for all its subscribers. Each continues after the record that it
// received last, and learns how many it has missed: a slow reader delays nobody.

/// A record, and as it goes out.
struct TraceItem {
  std::uint64_t id = 0;  ///< counts the records of this process from 1
  gateway::TraceRecord record;
  std::string text;  ///< a server-sent event
};

class TraceRing {
 public:
  /// Some seconds of the busiest plant. A record of usual size has 1 KiB.
  static constexpr std::size_t kMostBytes = 8U << 20U;

  struct Next {
    const TraceItem& item;   ///< until the next add()
    std::uint64_t lost = 0;  ///< how many between are not there
  };

  /// The oldest make room. Ids rise; one that is left out counts as lost.
  void add(TraceItem item);
  /// The id of the last one that was added; 0: there was none.
  [[nodiscard]] std::uint64_t newest() const { return newest_; }
  /// The first one after `id` that is there. Nothing: it is still to come.
  [[nodiscard]] std::optional<Next> after(std::uint64_t id) const;
  /// Nobody reads any more.
  void clear();

 private:
  static std::size_t size_of(const TraceItem& item);

  std::deque<TraceItem> items_;
  std::uint64_t newest_ = 0;
  std::size_t bytes_ = 0;
};

}  // namespace mbgate::app

// SPDX-License-Identifier: Apache-2.0
// The clients that read the trace. Used only on the thread of the HTTP interface.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "app/control/stream_readers.hpp"
#include "app/control/tcp_rules.hpp"
#include "app/trace/trace_json.hpp"
#include "gateway/trace/trace_book.hpp"
#include "modbus/result.hpp"

namespace mbgate::app {

/// Records that go over to this thread together.
struct TraceBatch {
  gateway::TraceBook::Taken taken;
  std::chrono::system_clock::time_point epoch;  ///< the time of day at the machine's instant 0
};

/// A record, and as it goes out.
struct TraceItem {
  std::uint64_t id = 0;  ///< counts the records of this process from 1
  gateway::TraceRecord record;
  std::string text;  ///< a server-sent event

  /// Its bytes are in the text, as two digits and a blank each: the record itself is smaller.
  [[nodiscard]] std::size_t size() const { return sizeof *this + 2 * text.size(); }
};
/// Some seconds of the busiest plant. A record of usual size has 1 KiB.
inline constexpr std::size_t kKeptTraceBytes = 8U << 20U;

class TraceStreams {
 public:
  /// Called when the first one comes and when the last one has gone, perhaps after this object.
  using Switch = std::function<void(bool)>;

  explicit TraceStreams(Switch set_traced) : set_traced_(std::move(set_traced)) {}

  /// Goes out to all of them.
  void add(TraceBatch batch);
  /// `query`: what stands behind the '?' of the request.
  [[nodiscard]] static Result<TraceFilter, Refusal> begin(std::string_view query);
  /// There is something new beside the trace.
  void wake() { readers_.wake(); }
  /// Sends what matches from now on, until the client goes or takes nothing for kClientLimit; and
  /// what `beside` gives, if there is one, until that is nothing.
  boost::asio::awaitable<void> feed(ControlStream& stream, TraceFilter filter,
                                    std::function<std::string()> beside);

 private:
  /// Each of them holds the same one. The last that lets go of it switches the trace off.
  using Subscription = std::shared_ptr<const void>;
  Subscription subscribe();
  /// The text to send after the record `last`, which moves on; empty as long as there is none.
  std::string next_text(const TraceFilter& filter, std::uint64_t& last) const;

  StreamReaders readers_;
  Switch set_traced_;
  std::weak_ptr<const void> subscription_;
  Ring<TraceItem> ring_{kKeptTraceBytes};
  std::uint64_t numbered_ = 0;  ///< records, also those that were lost
};

}  // namespace mbgate::app

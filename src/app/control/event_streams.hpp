// SPDX-License-Identifier: Apache-2.0
// The clients that follow the journal. Used only on the thread of the HTTP interface.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "app/control/stream_readers.hpp"
#include "app/control/tcp_rules.hpp"
#include "app/log.hpp"
#include "modbus/result.hpp"

namespace mbgate::app {

/// A line of the journal.
struct JournalEvent {
  std::uint64_t id = 0;  ///< counts the lines of this process from 1
  std::chrono::system_clock::time_point at;
  Level level = Level::info;
  std::string text;

  [[nodiscard]] static constexpr std::size_t size() { return 1; }
};
/// The journal gets at most ten lines a minute of one kind: these are some minutes of a bad day.
inline constexpr std::size_t kKeptEvents = 256;

class EventStreams {
 public:
  /// `numbered_from`: the first event of this process has the number after it.
  explicit EventStreams(std::uint64_t numbered_from) : numbered_from_(numbered_from) {}

  /// Goes out to all of them.
  void add(JournalEvent event);
  /// After which event a new stream begins. `last_event_id` is this header of the request: what an
  /// earlier process had numbered so is no reason to leave anything out.
  Result<std::uint64_t, Refusal> begin(std::optional<std::string_view> last_event_id);
  /// For a stream of something else that has them too: gives all that are kept, one at each call,
  /// then those that come; nothing if the next one is still to come.
  [[nodiscard]] std::function<std::string()> kept() const;
  /// Sends what comes after that event, until the client goes or takes nothing for kClientLimit.
  boost::asio::awaitable<void> feed(ControlStream& stream, std::uint64_t after);

 private:
  /// The text to send after the event `last`, which moves on; empty as long as there is none.
  std::string next_text(std::uint64_t& last) const;

  StreamReaders readers_;
  std::uint64_t numbered_from_;
  Ring<JournalEvent> ring_{kKeptEvents};
};

// Events as text: server-sent events (text/event-stream, in the HTML standard), with data in JSON
// (docs/api.yaml).

/// "id: 7", "event: journal" and "data: {...}", a line each, and the empty line that ends it.
std::string event_text(const JournalEvent& event);

/// "id: 7", "event: NAME" and "data: DATA"; `data` has no line ends.
std::string server_event(std::uint64_t id, std::string_view name, std::string_view data);

/// Says that so many events are missing. It has no id: whoever comes back still names the last one
/// that it had.
std::string lost_text(std::uint64_t lost);

}  // namespace mbgate::app

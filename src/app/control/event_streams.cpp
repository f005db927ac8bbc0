// SPDX-License-Identifier: Apache-2.0
#include "app/control/event_streams.hpp"

#include <algorithm>
#include <boost/beast/http/status.hpp>
#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <fmt/core.h>
#include <utility>

#include "app/text.hpp"
#include "base/text.hpp"

namespace mbgate::app {

void EventStreams::add(JournalEvent event) {
  ring_.add(std::move(event));
  readers_.wake();
}

Result<std::uint64_t, Refusal> EventStreams::begin(std::optional<std::string_view> last_event_id) {
  if (!last_event_id) {
    return std::max(ring_.newest(), numbered_from_);
  }
  const auto id = integer_in<std::uint64_t>(*last_event_id);
  if (!id) {
    return Refusal{boost::beast::http::status::bad_request,
                   "Last-Event-ID: expected the id of an event, a number"};
  }
  return *id >= numbered_from_ && *id <= ring_.newest() ? *id : numbered_from_;
}

boost::asio::awaitable<void> EventStreams::feed(ControlStream& stream, std::uint64_t after) {
  std::function<std::string()> next = [this, after]() mutable { return next_text(after); };
  co_await readers_.feed(stream, std::move(next));
}

std::function<std::string()> EventStreams::kept() const {
  const std::uint64_t oldest = ring_.oldest();
  return [this, last = oldest == 0 ? numbered_from_ : oldest - 1]() mutable {
    return next_text(last);
  };
}

std::string EventStreams::next_text(std::uint64_t& last) const {
  const auto next = ring_.after(last);
  if (!next) {
    return {};
  }
  last = next->item.id;
  return (next->lost > 0 ? lost_text(next->lost) : "") + event_text(next->item);
}

std::string event_text(const JournalEvent& event) {
  const boost::json::object data{{"at", utc_millisecond(event.at)},
                                 {"level", level_word(event.level)},
                                 {"text", valid_utf8(event.text)}};
  return server_event(event.id, "journal", boost::json::serialize(data));
}

std::string server_event(std::uint64_t id, std::string_view name, std::string_view data) {
  return fmt::format("id: {}\nevent: {}\ndata: {}\n\n", id, name, data);
}

std::string lost_text(std::uint64_t lost) {
  return fmt::format("event: lost\ndata: {{\"lost\":{}}}\n\n", lost);
}

}  // namespace mbgate::app

// SPDX-License-Identifier: Apache-2.0
#include "app/control/trace_streams.hpp"

#include <boost/beast/http/status.hpp>
#include <boost/json/serialize.hpp>
#include <utility>

#include "app/control/event_streams.hpp"

namespace mbgate::app {
namespace {

/// So much is written at a time.
constexpr std::size_t kPiece = 65536;

}  // namespace

TraceStreams::Subscription TraceStreams::subscribe() {
  Subscription subscription = subscription_.lock();
  if (!subscription) {
    set_traced_(true);
    subscription.reset(this, [set_traced = set_traced_](const void*) { set_traced(false); });
    subscription_ = subscription;
  }
  return subscription;
}

void TraceStreams::add(TraceBatch batch) {
  if (subscription_.expired()) {
    return;  // it was on its way when the last one left
  }
  numbered_ += batch.taken.lost;
  for (gateway::TraceRecord& record : batch.taken.records) {
    const std::uint64_t id = ++numbered_;
    std::string text = server_event(id, trace_kind(record),
                                    boost::json::serialize(trace_json(record, batch.epoch)));
    ring_.add({id, std::move(record), std::move(text)});
  }
  readers_.wake();
}

Result<TraceFilter, Refusal> TraceStreams::begin(std::string_view query) {
  auto filter = TraceFilter::parse(query);
  if (!filter) {
    return Refusal{boost::beast::http::status::bad_request, filter.error()};
  }
  return *std::move(filter);
}

boost::asio::awaitable<void> TraceStreams::feed(ControlStream& stream, TraceFilter filter,
                                                std::function<std::string()> beside) {
  const Subscription subscription = subscribe();
  std::function<std::string()> next = [this, filter = std::move(filter), last = numbered_,
                                       beside = std::move(beside)]() mutable {
    std::string text = beside ? beside() : "";
    return text += next_text(filter, last);
  };
  co_await readers_.feed(stream, std::move(next));
  if (subscription.use_count() == 1) {
    ring_.clear();  // nobody else reads
  }
}

std::string TraceStreams::next_text(const TraceFilter& filter, std::uint64_t& last) const {
  std::string text;
  while (text.size() < kPiece) {
    const auto next = ring_.after(last);
    if (!next) {
      break;
    }
    text += next->lost > 0 ? lost_text(next->lost) : "";
    last = next->item.id;
    text += filter.matches(next->item.record) ? next->item.text : "";
  }
  return text;
}

}  // namespace mbgate::app

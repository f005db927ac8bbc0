// SPDX-License-Identifier: Apache-2.0
// Answers the requests of the HTTP interface. Used only on its own thread, except for its
// construction.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/json/object.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "app/control/asker.hpp"
#include "app/control/control_doors.hpp"
#include "app/control/control_target.hpp"
#include "app/control/event_streams.hpp"
#include "app/control/request_reader.hpp"
#include "app/control/stream_readers.hpp"
#include "app/control/trace_streams.hpp"
#include "gateway/settings.hpp"
#include "io/supervise.hpp"

namespace mbgate::app {

class ControlServer {
 public:
  /// `numbered_from`: the first event has the number after it. `set_traced`: see TraceStreams.
  ControlServer(const std::shared_ptr<boost::asio::io_context>& home,
                boost::asio::io_context& gateway, ControlTarget& target,
                std::uint64_t numbered_from, TraceStreams::Switch set_traced);

  ControlDoors& doors() { return doors_; }
  void apply(const gateway::HttpSettings& settings);
  void tell(JournalEvent event) {
    events_.add(std::move(event));
    traces_.wake();  // those who read both
  }
  void trace(TraceBatch batch) { traces_.add(std::move(batch)); }

 private:
  using Request = boost::beast::http::request<boost::beast::http::string_body>;
  using Response = boost::beast::http::response<boost::beast::http::string_body>;
  struct Status {
    gateway::StatusReport report;
    ProcessStatus process;
  };

  boost::asio::awaitable<void> serve_one(ControlDoors::Entered client);
  /// What a connection becomes that is a stream from then on: of events after this one, or of a
  /// trace.
  using Stream = std::variant<std::uint64_t, TraceFilter>;
  /// Until the connection ends, or is to be a stream.
  boost::asio::awaitable<std::optional<Stream>> serve(ControlDoors::Entered& client);
  /// Nothing: it is no request for a stream.
  std::optional<Result<Stream, Refusal>> begin_stream(const Request& request,
                                                      const StreamPlaces::Reader& asker);
  /// What a request without a refusal is answered, if it is none for a stream.
  boost::asio::awaitable<Response> respond(const Request& request, const Asker& asker);
  /// Why a request gets no other answer, or nothing. Counts commands.
  std::optional<Refusal> refused(const ControlDoors::Entered& client,
                                 const RequestReader::Incoming& incoming);
  /// The journal, of a command over the Unix socket that came to nothing.
  void tell_denied(const std::string& what, const Asker& asker);
  /// Nothing: the gateway's thread has not answered in time.
  boost::asio::awaitable<std::optional<Status>> ask_status(bool with_clients);
  boost::asio::awaitable<Response> status(const Request& request);
  boost::asio::awaitable<Response> metrics(const Request& request);
  boost::asio::awaitable<Response> health(const Request& request);
  boost::asio::awaitable<Response> reload(const Request& request, const Asker& asker);
  boost::asio::awaitable<Response> clear_counters(const Request& request, const Asker& asker);

  std::shared_ptr<boost::asio::io_context> home_;
  boost::asio::io_context& gateway_;
  ControlTarget& target_;
  ControlDoors doors_;
  std::vector<std::string> hosts_;  ///< names of this machine
  bool client_metrics_ = false;
  CommandLimit commands_;
  StreamPlaces streams_{gateway::HttpSettings{}.max_streams};
  EventStreams events_;
  TraceStreams traces_;
  boost::json::object last_;
  std::optional<std::chrono::steady_clock::time_point> last_at_;
};

/// A question from one thread to another. The coroutine that asks waits for the answer, up to a
/// limit. `home` is the context of the thread that asks.
template <typename Value>
class Question {
 public:
  explicit Question(const std::shared_ptr<boost::asio::io_context>& home)
      : home_(home), state_(std::make_shared<State>(*home)) {}

  /// What gives the answer, from the other thread, once. Safe when nobody waits any more.
  [[nodiscard]] std::function<void(Value)> taker() const {
    return [home = std::weak_ptr(home_), state = std::weak_ptr(state_)](Value value) {
      if (const auto running = home.lock()) {
        boost::asio::post(*running, [state, value = std::move(value)]() mutable {
          if (const auto waiting = state.lock()) {
            waiting->value = std::move(value);
            waiting->timer.cancel();
          }
        });
      }
    };
  }

  /// What says, on any thread, whether somebody still waits.
  [[nodiscard]] std::function<bool()> is_awaited() const {
    return [state = std::weak_ptr(state_)] { return !state.expired(); };
  }

  boost::asio::awaitable<std::optional<Value>> wait(std::chrono::seconds limit) {
    state_->timer.expires_after(limit);
    co_await state_->timer.async_wait(io::kAsTuple);
    co_return std::move(state_->value);
  }

 private:
  struct State {
    explicit State(boost::asio::io_context& context) : timer(context) {}
    boost::asio::steady_timer timer;
    std::optional<Value> value;
  };

  std::weak_ptr<boost::asio::io_context> home_;
  std::shared_ptr<State> state_;
};

}  // namespace mbgate::app

// SPDX-License-Identifier: Apache-2.0
// Answers the requests on the control socket. Used on the thread of the socket alone, but for its
// construction.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/json/object.hpp>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "app/control/connection.hpp"
#include "app/control/control_target.hpp"
#include "app/control/event_streams.hpp"

namespace mbgate::app {

class ControlServer {
 public:
  /// `numbered_from`: the first event has the number after it.
  ControlServer(const std::shared_ptr<boost::asio::io_context>& home,
                boost::asio::io_context& gateway, ControlTarget& target,
                boost::asio::local::stream_protocol::acceptor acceptor, std::uint64_t numbered_from)
      : home_(home),
        gateway_(gateway),
        target_(target),
        acceptor_(std::move(acceptor)),
        events_(numbered_from) {}

  boost::asio::awaitable<void> accept();
  void tell(JournalEvent event) { events_.add(std::move(event)); }

 private:
  using Request = boost::beast::http::request<boost::beast::http::string_body>;
  using Response = boost::beast::http::response<boost::beast::http::string_body>;
  /// A connection as long as it counts.
  class Counted {
   public:
    explicit Counted(std::shared_ptr<std::size_t> count) : count_(std::move(count)) { ++*count_; }
    Counted(const Counted&) = delete;
    Counted& operator=(const Counted&) = delete;
    ~Counted() { --*count_; }

   private:
    std::shared_ptr<std::size_t> count_;  // it may be there for longer than the server
  };
  struct Status {
    gateway::StatusReport report;
    ProcessStatus process;
  };

  boost::asio::awaitable<void> serve_one(ControlStream stream);
  /// Until the connection ends, or is to be a stream of events: then after which one.
  boost::asio::awaitable<std::optional<std::uint64_t>> serve(ControlStream& stream);
  boost::asio::awaitable<Response> respond(const Request& request);
  /// Nothing: the gateway's thread has not answered in time.
  boost::asio::awaitable<std::optional<Status>> ask_status();
  boost::asio::awaitable<Response> status(const Request& request);
  boost::asio::awaitable<Response> health(const Request& request);
  boost::asio::awaitable<Response> reload(const Request& request);
  boost::asio::awaitable<Response> clear_counters(const Request& request);

  std::shared_ptr<boost::asio::io_context> home_;
  boost::asio::io_context& gateway_;
  ControlTarget& target_;
  boost::asio::local::stream_protocol::acceptor acceptor_;
  /// But for streams of events.
  std::shared_ptr<std::size_t> connections_ = std::make_shared<std::size_t>(0);
  EventStreams events_;
  boost::json::object last_;
  std::optional<std::chrono::steady_clock::time_point> last_at_;
};

}  // namespace mbgate::app

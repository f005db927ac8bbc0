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

#include "app/control/connection.hpp"
#include "app/control/control_target.hpp"
#include "app/control/event_streams.hpp"

namespace mbgate::app {

class ControlServer {
 public:
  ControlServer(const std::shared_ptr<boost::asio::io_context>& home,
                boost::asio::io_context& gateway, ControlTarget& target,
                boost::asio::local::stream_protocol::acceptor acceptor)
      : home_(home), gateway_(gateway), target_(target), acceptor_(std::move(acceptor)) {}

  boost::asio::awaitable<void> accept();
  /// No more connections.
  void close();
  void tell(JournalEvent event) { events_.add(std::move(event)); }

 private:
  using Request = boost::beast::http::request<boost::beast::http::string_body>;
  using Response = boost::beast::http::response<boost::beast::http::string_body>;
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

  std::shared_ptr<boost::asio::io_context> home_;
  boost::asio::io_context& gateway_;
  ControlTarget& target_;
  boost::asio::local::stream_protocol::acceptor acceptor_;
  std::size_t connections_ = 0;  ///< but for streams of events
  EventStreams events_;
  boost::json::object last_;
  std::optional<std::chrono::steady_clock::time_point> last_at_;
};

}  // namespace mbgate::app

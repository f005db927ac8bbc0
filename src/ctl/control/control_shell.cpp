// SPDX-License-Identifier: Apache-2.0
#include "ctl/control/control_shell.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/json/parse.hpp>
#include <utility>

#include "ctl/control/connection_shell.hpp"
#include "ctl/visible_text.hpp"

namespace mbgate::ctl {
namespace {

namespace http = boost::beast::http;

std::string not_answered(std::chrono::seconds limit) {
  return "mbgated has not answered within " + std::to_string(limit.count()) + " s";
}

http::request<http::empty_body> request_for(const ControlConnection& connection,
                                            const std::string& method, const std::string& target) {
  http::request<http::empty_body> request(http::string_to_verb(method), target, 11);
  request.set(http::field::host, host_of(connection));
  request.set(http::field::connection, "close");
  request.prepare_payload();
  return request;
}

Result<ControlAnswer, std::string> parsed_answer(
    const std::string& place, const http::response<http::string_body>& response) {
  boost::system::error_code error;
  const auto json = boost::json::parse(response.body(), error);
  if (error || !json.is_object()) {
    return place + ": what answers there is not mbgated";
  }
  return ControlAnswer{response.result_int(), json.get_object()};
}

/// A request that is sent, and the response that comes, as far as they have got.
class Exchange {
 public:
  Exchange(ControlConnection& connection, const std::string& method, const std::string& target)
      : connection_(connection), request_(request_for(connection, method, target)) {}

  void start() {
    http::async_write(connection_, request_,
                      [this](const boost::system::error_code& error, std::size_t /*bytes*/) {
                        error_ = error;
                        if (!error) {
                          read();
                        }
                      });
  }

  [[nodiscard]] const boost::system::error_code& error() const { return error_; }
  [[nodiscard]] const http::response<http::string_body>& response() const { return response_; }

 private:
  void read() {
    http::async_read(
        connection_, buffer_, response_,
        [this](const boost::system::error_code& error, std::size_t /*bytes*/) { error_ = error; });
  }

  ControlConnection& connection_;
  http::request<http::empty_body> request_;
  boost::beast::flat_buffer buffer_;
  http::response<http::string_body> response_;
  boost::system::error_code error_;
};

/// Runs what was started, to its end or that of the patience.
void run(boost::asio::io_context& context, const Patience& patience) {
  while (!context.stopped() && !patience.is_over()) {
    context.run_until(std::min(patience.end, std::chrono::steady_clock::now() + kLook));
  }
}

/// mbgated sends a comment every 15 s at least.
constexpr std::chrono::seconds kSilenceLimit{45};

/// A connection whose answer is read piece by piece. Each step may take kSilenceLimit; after one
/// that has failed there must be no other.
class EndlessAnswer {
 public:
  explicit EndlessAnswer(const std::string& place) : place_(place), connection_(context_) {}

  /// Connects, and sends the request. Returns why not, or nothing.
  std::string ask(const std::string& target) {
    error_ = connect(connection_, place_, {std::chrono::steady_clock::now() + kSilenceLimit, {}});
    request_ = request_for(connection_, "GET", target);
    if (!error_) {
      do_within_limit([&](auto done) { http::async_write(connection_, request_, done); });
    }
    return failure();
  }

  template <typename Parser>
  std::string read_header(Parser& parser) {
    do_within_limit(
        [&](auto done) { http::async_read_header(connection_, buffer_, parser, done); });
    return failure();
  }

  template <typename Parser>
  std::string read(Parser& parser) {
    do_within_limit([&](auto done) { http::async_read(connection_, buffer_, parser, done); });
    return failure();
  }

  /// What has come is in the body of the parser.
  template <typename Parser>
  boost::system::error_code read_some(Parser& parser) {
    do_within_limit([&](auto done) { http::async_read_some(connection_, buffer_, parser, done); });
    return error_ == http::error::need_buffer ? boost::system::error_code() : error_;
  }

 private:
  template <typename Start>
  void do_within_limit(Start start) {
    error_ = boost::asio::error::timed_out;
    start(
        [this](const boost::system::error_code& error, std::size_t /*bytes*/) { error_ = error; });
    context_.restart();
    context_.run_for(kSilenceLimit);
  }

  [[nodiscard]] std::string failure() const {
    if (error_ == boost::asio::error::timed_out) {
      return not_answered(kSilenceLimit);
    }
    return error_ ? explain(place_, error_) : std::string();
  }

  std::string place_;
  boost::system::error_code error_;
  http::request<http::empty_body> request_;
  boost::beast::flat_buffer buffer_;
  boost::asio::io_context context_;
  ControlConnection connection_;
};

std::string follow_body(EndlessAnswer& answer, http::response_parser<http::buffer_body>& parser,
                        const Interruption& interruption,
                        const std::function<bool(std::string_view)>& take) {
  parser.body_limit(boost::none);  // it has no end
  std::array<char, 4096> piece{};
  while (!parser.is_done()) {
    auto& body = parser.get().body();
    body.data = piece.data();
    body.size = piece.size();
    const auto error = interruption.endable([&] { return answer.read_some(parser); });
    if (error == boost::asio::error::timed_out) {
      return "mbgated has sent nothing for " + std::to_string(kSilenceLimit.count()) + " s";
    }
    if (!take({piece.data(), piece.size() - body.size})) {
      return {};
    }
    if (error) {
      break;
    }
  }
  return "mbgated has ended, or sends no more (journalctl -u mbgated)";
}

}  // namespace

std::string error_of(const ControlAnswer& answer) {
  const auto* const error = answer.json.if_contains("error");
  return error != nullptr && error->is_string()
             ? visible_text(error->get_string())
             : "unexpected answer, HTTP status " + std::to_string(answer.status);
}

Result<ControlAnswer, std::string> ask_control(const std::string& place, const std::string& method,
                                               const std::string& target,
                                               std::chrono::seconds limit,
                                               const std::function<bool()>& give_up) {
  if (std::string why = wrong_place(place); !why.empty()) {
    return why;
  }
  const Patience patience{std::chrono::steady_clock::now() + limit, give_up};
  boost::asio::io_context context;
  ControlConnection connection(context);
  boost::system::error_code error = connect(connection, place, patience);
  Exchange exchange(connection, method, target);
  if (!error) {
    exchange.start();
    run(context, patience);
    error = context.stopped() ? exchange.error() : boost::asio::error::timed_out;
  }
  if (error == boost::asio::error::timed_out) {
    return not_answered(limit);
  }
  if (error) {
    return explain(place, error);
  }
  return parsed_answer(place, exchange.response());
}

std::string follow_control(const std::string& place, const std::string& target,
                           const Interruption& interruption,
                           const std::function<bool(std::string_view)>& take) {
  if (std::string why = wrong_place(place); !why.empty()) {
    return why;
  }
  EndlessAnswer answer(place);
  http::response_parser<http::empty_body> head;
  std::string failure = interruption.endable([&] {
    std::string why = answer.ask(target);
    return why.empty() ? answer.read_header(head) : why;
  });
  if (!failure.empty()) {
    return failure;
  }
  if (head.get().result() == http::status::ok) {
    http::response_parser<http::buffer_body> body(std::move(head));
    return follow_body(answer, body, interruption, take);
  }
  http::response_parser<http::string_body> refusal(std::move(head));
  failure = interruption.endable([&] { return answer.read(refusal); });
  if (!failure.empty()) {
    return failure;
  }
  const auto refused = parsed_answer(place, refusal.get());
  return refused ? error_of(*refused) : refused.error();
}

}  // namespace mbgate::ctl

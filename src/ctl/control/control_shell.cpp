// SPDX-License-Identifier: Apache-2.0
#include "ctl/control/control_shell.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/json/parse.hpp>
#include <fmt/core.h>
#include <utility>

#include "ctl/control/connection_shell.hpp"
#include "ctl/visible_text.hpp"

namespace mbgate::ctl {
namespace {

namespace http = boost::beast::http;

Result<ControlAnswer, std::string> parsed_answer(
    const std::string& place, const http::response<http::string_body>& response) {
  boost::system::error_code error;
  const auto json = boost::json::parse(response.body(), error);
  if (error || !json.is_object()) {
    return place + ": the server there is not mbgated";
  }
  return ControlAnswer{response.result_int(), json.get_object()};
}

/// A status has all devices and clients in it.
constexpr std::uint64_t kLongestAnswer = std::uint64_t{64} << 20U;

/// mbgated sends a comment every 15 s at least.
constexpr std::chrono::seconds kSilenceLimit{45};

/// A request, and its answer, which may be read piece by piece. After a step that has failed there
/// must be no other.
class Exchange {
 public:
  /// `limit`: for each step, or for all of them together. `give_up`: as of ask_control().
  Exchange(const std::string& place, std::chrono::seconds limit, bool for_all,
           std::function<bool()> give_up = {})
      : place_(place),
        limit_(limit),
        for_all_(for_all),
        give_up_(std::move(give_up)),
        wait_limit_{std::chrono::steady_clock::now() + limit, give_up_},
        connection_(context_) {}

  /// Connects, and sends the request. Returns why not, or nothing.
  std::string ask(const std::string& method, const std::string& target) {
    error_ = connect(connection_, place_, wait_limit_);
    request_ = {http::string_to_verb(method), target, 11};
    request_.set(http::field::host, host_of(connection_));
    request_.set(http::field::connection, "close");
    request_.prepare_payload();
    if (!error_) {
      do_in_time([&](auto done) { http::async_write(connection_, request_, done); });
    }
    return failure();
  }

  template <typename Parser>
  std::string read_header(Parser& parser) {
    do_in_time([&](auto done) { http::async_read_header(connection_, buffer_, parser, done); });
    return failure();
  }

  template <typename Parser>
  std::string read(Parser& parser) {
    do_in_time([&](auto done) { http::async_read(connection_, buffer_, parser, done); });
    return failure();
  }

  /// What has come is in the body of the parser.
  template <typename Parser>
  boost::system::error_code read_some(Parser& parser) {
    do_in_time([&](auto done) { http::async_read_some(connection_, buffer_, parser, done); });
    return error_ == http::error::need_buffer ? boost::system::error_code() : error_;
  }

 private:
  template <typename Start>
  void do_in_time(Start start) {
    error_ = boost::asio::error::timed_out;
    start(
        [this](const boost::system::error_code& error, std::size_t /*bytes*/) { error_ = error; });
    if (!for_all_) {
      wait_limit_.end = std::chrono::steady_clock::now() + limit_;
    }
    context_.restart();
    while (!context_.stopped() && !wait_limit_.is_over()) {
      const auto look = std::chrono::steady_clock::now() + kLook;
      context_.run_until(give_up_ ? std::min(wait_limit_.end, look) : wait_limit_.end);
    }
  }

  [[nodiscard]] std::string failure() const {
    if (error_ == boost::asio::error::timed_out) {
      return fmt::format("mbgated has not answered within {} s{}", limit_.count(),
                         request_.method() == http::verb::post ? "; it may still be done" : "");
    }
    return error_ ? explain(place_, error_) : std::string();
  }

  std::string place_;
  std::chrono::seconds limit_;
  bool for_all_;
  std::function<bool()> give_up_;
  WaitLimit wait_limit_;
  boost::system::error_code error_;
  http::request<http::empty_body> request_;
  boost::beast::flat_buffer buffer_;
  boost::asio::io_context context_;
  ControlConnection connection_;
};

std::string follow_body(Exchange& answer, http::response_parser<http::buffer_body>& parser,
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
      return fmt::format("mbgated has sent nothing for {} s", kSilenceLimit.count());
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
             : fmt::format("unexpected answer, HTTP status {}", answer.status);
}

std::string other_version(const std::exception& exception) {
  return fmt::format("mbgated and mbgatectl have different versions: {}", exception.what());
}

Result<ControlAnswer, std::string> ask_control(const std::string& place, const std::string& method,
                                               const std::string& target,
                                               std::chrono::seconds limit,
                                               const std::function<bool()>& give_up) {
  Exchange exchange(place, limit, true, give_up);
  http::response_parser<http::string_body> response;
  response.body_limit(kLongestAnswer);
  std::string failure = exchange.ask(method, target);
  if (failure.empty()) {
    failure = exchange.read(response);
  }
  return failure.empty() ? parsed_answer(place, response.get()) : failure;
}

std::string follow_control(const std::string& place, const std::string& target,
                           const Interruption& interruption,
                           const std::function<bool(std::string_view)>& take) {
  Exchange answer(place, kSilenceLimit, false);
  http::response_parser<http::empty_body> head;
  std::string failure = interruption.endable([&] {
    std::string why = answer.ask("GET", target);
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

// SPDX-License-Identifier: Apache-2.0
#include "ctl/control/control_shell.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/json/parse.hpp>
#include <cerrno>
#include <thread>
#include <utility>

namespace mbgate::ctl {
namespace {

namespace http = boost::beast::http;
using boost::asio::local::stream_protocol;

std::string explain(const std::string& socket, const boost::system::error_code& error) {
  if (error == boost::system::errc::no_such_file_or_directory) {
    return "there is no control socket at " + socket +
           ": is mbgated running (systemctl status mbgated)? Where [http] socket names another "
           "path, give it with --control";
  }
  if (error == boost::system::errc::permission_denied) {
    return "no permission for " + socket + ": run it as root, or as a member of its group";
  }
  if (error == boost::system::errc::connection_refused) {
    return "nobody listens at " + socket + " any more: mbgated has ended (journalctl -u mbgated)";
  }
  return socket + ": " + error.message();
}

std::string not_answered(std::chrono::seconds limit) {
  return "mbgated has not answered within " + std::to_string(limit.count()) + " s";
}

/// Why there can be no socket at this path, or nothing.
std::string too_long(const std::string& socket) {
  return socket.size() < sizeof(sockaddr_un::sun_path)
             ? std::string()
             : socket + ": the path of a socket has at most " +
                   std::to_string(sizeof(sockaddr_un::sun_path) - 1) + " characters";
}

http::request<http::empty_body> request_for(const std::string& method, const std::string& target) {
  http::request<http::empty_body> request(http::string_to_verb(method), target, 11);
  request.set(http::field::host, "mbgated");
  request.set(http::field::connection, "close");
  request.prepare_payload();
  return request;
}

Result<ControlAnswer, std::string> parsed_answer(
    const std::string& socket, const http::response<http::string_body>& response) {
  boost::system::error_code error;
  const auto json = boost::json::parse(response.body(), error);
  if (error || !json.is_object()) {
    return socket + ": what answers there is not mbgated";
  }
  return ControlAnswer{response.result_int(), json.get_object()};
}

/// How long a wish to give up goes unnoticed.
constexpr std::chrono::milliseconds kLook{50};

/// A request that is sent, and the response that comes, as far as they have got.
class Exchange {
 public:
  Exchange(stream_protocol::socket& connection, const std::string& method,
           const std::string& target)
      : connection_(connection), request_(request_for(method, target)) {}

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

  stream_protocol::socket& connection_;
  http::request<http::empty_body> request_;
  boost::beast::flat_buffer buffer_;
  http::response<http::string_body> response_;
  boost::system::error_code error_;
};

/// How long the answer is waited for.
struct Patience {
  std::chrono::steady_clock::time_point end;
  const std::function<bool()>& give_up;

  [[nodiscard]] bool is_over() const {
    return std::chrono::steady_clock::now() >= end || (give_up && give_up());
  }
};

/// A Unix socket is connected at once, or its queue is full because mbgated hangs: then the kernel
/// would wait without end.
boost::system::error_code connect(stream_protocol::socket& connection, const std::string& path,
                                  const Patience& patience) {
  const stream_protocol::endpoint endpoint(path);
  boost::system::error_code error;
  static_cast<void>(connection.open(endpoint.protocol(), error));
  if (!error) {
    static_cast<void>(connection.native_non_blocking(true, error));
  }
  while (!error) {
    if (::connect(connection.native_handle(), endpoint.data(),
                  static_cast<socklen_t>(endpoint.size())) == 0) {
      break;
    }
    if (errno != EAGAIN) {
      error.assign(errno, boost::system::system_category());
    } else if (patience.is_over()) {
      error = boost::asio::error::timed_out;
    } else {
      std::this_thread::sleep_for(kLook);
    }
  }
  return error;
}

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
  explicit EndlessAnswer(const std::string& path) : path_(path), connection_(context_) {}

  /// Connects, and sends the request. Returns why not, or nothing.
  std::string ask(const std::string& target) {
    error_ = connect(connection_, path_, {std::chrono::steady_clock::now() + kSilenceLimit, {}});
    request_ = request_for("GET", target);
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
    return error_ ? explain(path_, error_) : std::string();
  }

  std::string path_;
  boost::system::error_code error_;
  http::request<http::empty_body> request_;
  boost::beast::flat_buffer buffer_;
  boost::asio::io_context context_;
  stream_protocol::socket connection_;
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
             ? std::string(error->get_string())
             : "unexpected answer, HTTP status " + std::to_string(answer.status);
}

Result<ControlAnswer, std::string> ask_control(const std::string& socket, const std::string& method,
                                               const std::string& target,
                                               std::chrono::seconds limit,
                                               const std::function<bool()>& give_up) {
  if (std::string why = too_long(socket); !why.empty()) {
    return why;
  }
  const Patience patience{std::chrono::steady_clock::now() + limit, give_up};
  boost::asio::io_context context;
  stream_protocol::socket connection(context);
  boost::system::error_code error = connect(connection, socket, patience);
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
    return explain(socket, error);
  }
  return parsed_answer(socket, exchange.response());
}

std::string follow_control(const std::string& socket, const std::string& target,
                           const Interruption& interruption,
                           const std::function<bool(std::string_view)>& take) {
  if (std::string why = too_long(socket); !why.empty()) {
    return why;
  }
  EndlessAnswer answer(socket);
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
  const auto refused = parsed_answer(socket, refusal.get());
  return refused ? error_of(*refused) : refused.error();
}

}  // namespace mbgate::ctl
